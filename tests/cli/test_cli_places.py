"""Where results go: places that cannot be written, RUN folders that cannot be read."""

import json
import os
import shutil
import sys
from pathlib import Path
from typing import Any

import pytest
from processes import ORBIDENT, finished
from random_motions import random_motion
from running import LINEAR, Orbident, resealed, written

from orbident.files.replacing import locked
from orbident.identified.run_folder import load_result
from orbident.recordings.recording import Recording
from orbident.robot.robot_file import load_robot
from orbident.trajectories.trajectory_file import save_trajectory

as_root = pytest.mark.skipif(
    os.geteuid() == 0, reason="root may write and read everywhere"
)


@pytest.fixture(scope="module")
def made(flight: Recording, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a RUN and its recording `r.csv`, which every test copies."""
    folder = tmp_path_factory.mktemp("made")
    written(flight, folder / "r.csv", rows=slice(40))
    ran = finished(*ORBIDENT, *IDENTIFY, "-o", "run", "--quiet", cwd=folder)
    assert (ran.returncode, ran.stderr) == (0, "")
    return folder


@pytest.fixture
def run(made: Path) -> Path:
    """A RUN folder beside its recording `r.csv`."""
    shutil.copytree(made, Path(), dirs_exist_ok=True)
    return Path("run")


@pytest.fixture
def motion() -> Path:
    save_trajectory(random_motion(load_robot("paper-spatial"), duration=1.0), "m.yaml")
    return Path("m.yaml")


IDENTIFY = ("identify", "paper-spatial", "r.csv", *LINEAR)

COMMANDS = [
    ("robots",),
    ("inspect", "paper-spatial"),
    ("simulate", "paper-spatial", "m.yaml", "-o", "s.csv"),
    IDENTIFY,
    ("validate", "run", "r.csv"),
    ("study", "spatial"),
]


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: command[0])
def test_json_into_a_missing_folder(orbident: Orbident, command: tuple[str, ...]):
    """Refused before any work is done: not even the inputs are looked at."""
    orbident(*command, "--json", "gone/x.json").refused("gone/x.json", "create it")


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: command[0])
def test_json_onto_a_folder(orbident: Orbident, command: tuple[str, ...]):
    Path("folder").mkdir()
    orbident(*command, "--json", "folder").refused("folder: is a folder")


def test_simulate_into_a_missing_folder(orbident: Orbident, motion: Path):
    run = ("simulate", "paper-spatial", motion, "-o")
    orbident(*run, "gone/r.csv").refused("gone/r.csv", "create it")
    orbident(*run, "r.txt").refused(
        "r.txt: the name of a recording ends in .csv or .parquet"
    )
    orbident(*run, "r").refused("r: the name of a recording ends in")
    Path("folder.csv").mkdir()
    orbident(*run, "folder.csv").refused("folder.csv: is a folder")


def test_identify_makes_the_folders_of_its_run(orbident: Orbident, run: Path):
    orbident(*IDENTIFY, "-o", "deep/er/run", "--quiet").done()
    assert Path("deep/er/run/result.json").is_file()


def test_identify_below_a_file(orbident: Orbident, run: Path):
    orbident("identify", "paper-spatial", "r.csv", "-o", "r.csv/run").refused(
        "r.csv/run: ", "file"
    )
    orbident("identify", "paper-spatial", "r.csv", "-o", "r.csv").refused("r.csv: ")
    assert Path("r.csv").is_file()


def test_study_below_a_file(orbident: Orbident):
    Path("taken").write_text("")
    orbident("study", "spatial", "-o", "taken").refused("taken' is a file")
    orbident("study", "spatial", "-o", "taken/x").refused("taken' is a file")


@pytest.mark.parametrize("name", ["trajectory.yaml", "recording.csv"])
def test_study_spares_what_is_there(orbident: Orbident, name: str):
    Path(name).write_text("mine")
    orbident("study", "spatial", "-o", ".").refused(f"{name}: exists already")
    assert Path(name).read_text() == "mine"


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="needs Linux's /proc")
def test_places_that_refuse(orbident: Orbident, motion: Path):
    orbident("robots", "--quiet", "--json", "/proc/x.json").refused(
        "/proc/x.json: cannot be written"
    )
    orbident(
        "simulate", "paper-spatial", motion, "-o", "/proc/r.csv", "--quiet"
    ).refused("/proc/r.csv: cannot be written")


def test_json_into_a_pipe(orbident: Orbident):
    """As with a shell's `--json >(jq .mass)`: the pipe is not replaced by a file."""
    os.mkfifo("pipe")
    reader = os.open("pipe", os.O_RDONLY | os.O_NONBLOCK)
    orbident("robots", "--json", "pipe").done()
    assert json.loads(os.read(reader, 1 << 16))["robots"]
    os.close(reader)
    assert Path("pipe").is_fifo()


@pytest.mark.parametrize("name", ["r.csv", "r.yaml", "flight.mat", "run/result.json"])
def test_a_pipe_for_a_file(orbident: Orbident, name: str):
    """Nobody writes into it, and nobody waits."""
    Path("run").mkdir()
    os.mkfifo(name)
    command = {
        "r.csv": ("identify", "paper-spatial", "r.csv"),
        "r.yaml": ("check", "r.yaml"),
        "flight.mat": ("topics", "flight.mat"),
        "run/result.json": ("report", "run"),
    }[name]
    orbident(*command).refused(f"{name}: is a pipe or a device, which cannot be read")


def test_standard_input_for_a_file(orbident: Orbident):
    orbident("identify", "paper-spatial", "/dev/null").refused("is a pipe or a device")


def test_in_a_folder_that_was_deleted(tmp_path: Path):
    gone = tmp_path / "gone"
    gone.mkdir()
    leave = ("sh", "-c", 'rmdir "$0"; exec "$@"', gone)
    command = ("identify", "paper-spatial", "r.csv", "-o", "run")
    ran = finished(*leave, *ORBIDENT, *command, cwd=gone)
    assert ran.returncode == 2
    assert ran.stderr == (
        "orbident: the folder that you are in was deleted; change to another with "
        "'cd'\n"
    )


@as_root
def test_unwritable_folder(orbident: Orbident, run: Path, motion: Path):
    Path("locked").mkdir(mode=0o500)
    for command in (
        (*IDENTIFY, "-o", "locked/run"),
        (*IDENTIFY, "--json", "locked/x.json"),
        ("simulate", "paper-spatial", motion, "-o", "locked/r.csv"),
        ("study", "spatial", "-o", "locked/study"),
    ):
        orbident(*command, "--quiet").refused("locked", "ermission denied")


@as_root
@pytest.mark.parametrize("name", ["r.csv", "r.urdf", "r.yaml"])
def test_unreadable_file(orbident: Orbident, name: str):
    Path(name).write_text("secret")
    Path(name).chmod(0)
    command = (
        ("identify", "paper-spatial", name) if name == "r.csv" else ("inspect", name)
    )
    orbident(*command).refused(name, "ermission denied")


def test_no_run(orbident: Orbident, run: Path):
    orbident("validate", "gone", "r.csv").refused("gone", "identify -o")
    Path("empty").mkdir()
    orbident("validate", "empty", "r.csv").refused("empty", "identify -o")
    orbident("validate", "r.csv", "r.csv").refused("r.csv", "identify -o")
    orbident("validate", "paper-spatial", "r.csv").refused("paper-spatial")


TRASH = {
    "empty": b"",
    "binary": b"\x00\xff\xfe" * 9,
    "cut off": b'{"schema": "orbident/result/2", "mass',
    "a list": b"[1, 2]",
    "a number": b"3",
    "nothing in it": b"{}",
    "deep": b"[" * 100_000,
}


@pytest.mark.parametrize("case", TRASH)
def test_corrupt_result(orbident: Orbident, run: Path, case: str):
    (run / "result.json").write_bytes(TRASH[case])
    orbident("validate", run, "r.csv").refused("run/result.json: ", "identify")


def edited(run: Path, *keys: str, value: Any) -> None:
    """One entry of result.json changed; removed where the value is `...`."""
    path = run / "result.json"
    document = json.loads(path.read_text())
    *path_to, last = keys
    place = document
    for key in path_to:
        place = place[key]
    if value is ...:
        del place[last]
    else:
        place[last] = value
    path.write_text(json.dumps(document))


EDITS: dict[str, tuple[tuple[str, ...], Any]] = {
    "no pi": (("pi",), ...),
    "no values of pi": (("pi", "values"), ...),
    "a word in pi": (("pi", "values"), ["one"] * 19),
    "fewer pi": (("pi", "values"), [1.0] * 18),
    "a list in pi": (("pi", "values"), [[1.0]] * 19),
    "pi of another robot": (
        ("pi",),
        {"names": ["pi_1"], "formulas": ["a"], "values": [1.0], "std": [1.0]},
    ),
    "no mass": (("mass",), None),
    "mass a word": (("mass", "value"), "heavy"),
}


@pytest.mark.parametrize("case", EDITS)
def test_edited_result(orbident: Orbident, run: Path, case: str):
    keys, value = EDITS[case]
    edited(run, *keys, value=value)
    orbident("validate", run, "r.csv").refused("run/result.json: was altered")
    resealed(run)
    orbident("validate", run, "r.csv").refused("identify again")


def test_result_of_another_version(orbident: Orbident, run: Path):
    edited(run, "schema", value="orbident/result/1")
    orbident("validate", run, "r.csv").refused("run/result.json: ", "orbident/result/2")


def test_result_without_checksums(orbident: Orbident, run: Path):
    """As it was written before there were any."""
    edited(run, "files", value=...)
    edited(run, "sha256", value=...)
    words = "run/result.json: has no checksums", "identify again"
    orbident("validate", run, "r.csv").refused(*words)


READERS = {
    "validate": ("validate", "run", "r.csv"),
    "export": ("export", "run", "-o", "x.urdf"),
    "report": ("report", "run", "--force"),
    "compare": ("compare", "run", "run"),
    "view": ("view", "run"),
}


@pytest.mark.parametrize("verb", READERS)
def test_damaged_files(orbident: Orbident, run: Path, verb: str):
    """Every verb that reads a RUN refuses what is cut off, altered or missing."""
    for name in ("robot.yaml", "robot.urdf", "signals.parquet", "replay.json"):
        whole = (run / name).read_bytes()
        for damaged in (b"", whole[:-1], whole[:-2] + b"x\n"):
            (run / name).write_bytes(damaged)
            orbident(*READERS[verb]).refused(f"run/{name}: was altered or cut off")
        (run / name).unlink()
        orbident(*READERS[verb]).refused(f"run/{name}: is missing; identify again")
        (run / name).write_bytes(whole)
    (run / "history.csv").write_text("t,M\n")
    orbident(*READERS[verb]).refused("run/history.csv: does not belong")


def test_force_touches_only_ours(orbident: Orbident, run: Path):
    """Also from inside, and through a link."""
    (run / "notes.txt").write_text("mine")
    (run / "sub").mkdir()
    (run / "history.csv").write_text("of another result")
    before = (run / "result.json").read_bytes()
    orbident(*IDENTIFY, "-o", "run").refused("run: exists already", "--force")
    assert (run / "result.json").read_bytes() == before
    written_there = {path.name for path in run.iterdir()} - {"history.csv"}
    Path("link").symlink_to("run")
    os.chdir("run")
    here = ("identify", "paper-spatial", "../r.csv", *LINEAR, "-o", ".", "--force")
    orbident(*here, "--quiet").done()
    os.chdir("..")
    orbident(*IDENTIFY, "-o", "link", "--force", "--quiet").done()
    assert Path("link").is_symlink()
    assert {path.name for path in run.iterdir()} == written_there
    assert (run / "notes.txt").read_text() == "mine"
    orbident("validate", "link", "r.csv").done()


def test_force_spares_what_is_no_run(orbident: Orbident, run: Path):
    Path("folder").mkdir()
    for name in ("notes.txt", "result.json"):
        mine = Path("folder") / name
        mine.write_text("{}")
        for force in ((), ("--force",)):
            command = (*IDENTIFY, "-o", "folder", *force)
            orbident(*command).refused("folder: is not a RUN folder")
        assert mine.read_text() == "{}"
        mine.rename(Path("folder") / "kept")
    Path("nowhere").symlink_to("gone")
    orbident(*IDENTIFY, "-o", "nowhere").refused("nowhere: is a link to nowhere")


def test_what_a_killed_identification_left(orbident: Orbident, run: Path):
    """What this version leaves is replaced, and what one that wrote in place left."""
    left = Path("left") / ".orbident-unfinished"
    left.mkdir(parents=True)
    (left / "robot.urdf").write_text("<robot")
    orbident("validate", "left", "r.csv").refused("left: is not complete", "identify")
    orbident(*IDENTIFY, "-o", "left", "--quiet").done()
    orbident("validate", "left", "r.csv").done()
    for name in ("result.json", "report.html"):
        (run / name).unlink()
    (run / "signals.parquet").write_bytes(b"")
    orbident(*IDENTIFY, "-o", "run", "--force", "--quiet").done()
    orbident("validate", "run", "r.csv").done()


def test_into_an_empty_folder(orbident: Orbident, run: Path):
    Path("empty").mkdir()
    orbident(*IDENTIFY, "-o", "empty", "--quiet").done()
    orbident("validate", "empty", "r.csv").done()


def test_somebody_else_is_writing(orbident: Orbident, run: Path):
    """One line, and nothing is lost."""
    before = {path.name: path.read_bytes() for path in run.iterdir()}
    busy = "run: another orbident process is writing there; wait"
    with locked(run):
        orbident(*IDENTIFY, "-o", "run", "--force").refused(busy)
        orbident("report", run, "--force").refused(busy)
    assert {path.name: path.read_bytes() for path in run.iterdir()} == before


def test_run_without_its_robot(orbident: Orbident, run: Path):
    (run / "robot.urdf").unlink()
    resealed(run)
    orbident("validate", run, "r.csv").refused("run/robot.yaml", "robot.urdf")
    (run / "robot.yaml").unlink()
    resealed(run)
    orbident("validate", run, "r.csv").refused("run/robot.yaml")


@pytest.mark.slow
def test_a_folder_that_the_locale_cannot_name(run: Path):
    """Neither Python nor Arrow opens it by its name as text."""
    folder = Path("Gerät")
    run.rename(folder)
    Path("r.csv").rename(folder / "ä.csv")
    plain = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    for command in (
        ("identify", "paper-spatial", folder / "ä.csv", *LINEAR, "-o", folder / "run"),
        ("report", folder / "run", "--force"),
    ):
        ran = finished(*ORBIDENT, *command, "--quiet", env=os.environ | plain)
        assert (ran.returncode, ran.stderr) == (0, "")
    assert load_result(folder / "run").input["file"] == "ä.csv"


@pytest.mark.skipif(
    sys.platform != "linux", reason="file names of other systems are text"
)
def test_a_recording_whose_name_is_not_text(orbident: Orbident, run: Path):
    name = os.fsdecode(b"\xff.csv")
    Path("r.csv").rename(name)
    command = ("identify", "paper-spatial", name, *LINEAR, "-o", "new", "--quiet")
    orbident(*command).done()
    assert load_result(Path("new")).input["file"] == "\\xff.csv"


def test_run_of_another_robot(orbident: Orbident, run: Path, table_run: Recording):
    written(table_run, "table.csv")
    orbident("validate", run, "table.csv").refused("table.csv: column")
