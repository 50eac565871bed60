"""Every verb that writes: how it is called, and what must be there after a fault."""

import os
import random
import shutil
import subprocess
from contextlib import AbstractContextManager
from pathlib import Path
from typing import NamedTuple

import processes

from orbident.errors import InputError
from orbident.files.replacing import UNFINISHED, write_text
from orbident.identified.run_folder import check_absent, load_result

OLD = "run"
"""A RUN that is there before."""
_LINEAR = ("paper-spatial", "r.csv", "--method", "least-squares", "--quiet")
IDENTIFY = ("identify", *_LINEAR, "-o", OLD)
STUDY = ("study", "spatial", "--quiet", "--force", "-o", "study")
TO = ("--force", "-o")
EXCITE = ("excite", "paper-spatial", "--starts", "1", "--harmonics", "1", "--quiet")

VERBS = {
    "topics": ("topics", "flight.mcap", "--quiet", *TO, "map.yaml"),
    "convert": ("convert", "flight.mcap", "--map", "topics.yaml", *TO, "c.parquet"),
    "robots --json": ("robots", "--quiet", "--json", "robots.json"),
    "export": ("export", OLD, "--quiet", *TO, "x.urdf"),
    "export mcap": ("export", OLD, "--recording", "r.csv", "--quiet", *TO, "x.mcap"),
    "sample": ("sample", "t.yaml", "--rate", "5", "--quiet", *TO, "s.csv"),
    "simulate": ("simulate", "paper-spatial", "t.yaml", "--quiet", *TO, "m.csv"),
    "report": ("report", OLD, "--force", "--quiet"),
    "identify": ("identify", *_LINEAR, "-o", "first"),
    "identify --force": ("identify", *_LINEAR, "--force", "-o", OLD),
    "excite": (*EXCITE, *TO, "e.yaml"),
    "study": STUDY,
}
PLACES = {name: arguments[-1] for name, arguments in VERBS.items()}
PLACES["report"] = f"{OLD}/report.html"
QUICK = ("topics", "convert", "robots --json", "identify --force")
"""What takes the least time of each kind."""
CHANGING = {"report.html", "result.json"}
"""Hold how long it took."""
NOTES = "mine"


class Shelf(NamedTuple):
    """Inputs, and what verbs make of them."""

    folder: Path
    made: dict[str, Path]

    def laid_out(self, name: str, folder: Path) -> None:
        """A folder with the inputs, and something older where the verb writes."""
        folder.mkdir()
        for each in ("flight.mcap", "topics.yaml", "t.yaml", "r.csv"):
            (folder / each).symlink_to(self.folder / each)
        shutil.copytree(self.made["run"], folder / OLD)
        (folder / OLD / "notes.txt").write_text(NOTES)
        place = folder / PLACES[name]
        if name == "study":
            place.mkdir()
            for made in _files(self.made[name]):
                if made.parts[0] != "run":
                    (place / made).write_text(NOTES)
        elif name not in {"identify", "identify --force", "report"}:
            place.write_text(NOTES)

    def check(self, name: str, folder: Path) -> None:
        """What was there is there, or has become complete new; nothing else."""
        assert (folder / OLD / "notes.txt").read_text() == NOTES
        _check_run(folder / OLD)
        place = folder / PLACES[name]
        if name == "identify":
            _check_first_run(place)
        elif name == "study":
            _check_first_run(place / "run")
            for made in _files(self.made[name]):
                if made.parts[0] != "run":
                    _check_file(place / made, self.made[name] / made)
        elif name not in {"identify --force", "report"}:
            _check_file(place, self.made[name])
            write_text(place, "")
            assert leftovers(folder) == []


def leftovers(folder: Path) -> list[Path]:
    """What is ours and not complete."""
    return list(folder.rglob(f"*{UNFINISHED}*"))


def started(
    name: str, folder: Path, program: tuple[str, ...] = ()
) -> AbstractContextManager[subprocess.Popen[str]]:
    """The verb as a process in that folder, run by this program."""
    command = (*program, *processes.ORBIDENT)
    return processes.started(*VERBS[name], command=command, cwd=folder)


def ended(process: subprocess.Popen[str]) -> tuple[int, str]:
    """Its status and what it said; one line if it was refused."""
    _, said = process.communicate(timeout=processes.LIMIT)
    assert "internal error" not in said
    assert "Traceback" not in said
    if process.returncode == 2:
        assert said.startswith("orbident: "), said
        assert said.count("\n") == 1, said
    return process.returncode, said


def faults(share: float) -> int:
    """How many of a kind the long run has, as a part of all kills."""
    return round(share * int(os.environ.get("ORBIDENT_FAULTS", "200")))


def chosen(
    seed: int, names: tuple[str, ...] = tuple(VERBS)
) -> tuple[str, random.Random]:
    """A verb, all in turn, and random numbers."""
    return names[seed % len(names)], random.Random(seed)


def _files(folder: Path) -> list[Path]:
    files = (path for path in folder.rglob("*") if path.is_file())
    return [path.relative_to(folder) for path in files]


def _check_run(folder: Path) -> None:
    assert load_result(folder).signals()
    assert (folder / "report.html").read_text().rstrip().endswith("</html>")


def _check_first_run(folder: Path) -> None:
    """Complete, or refused; in either case identified again without a hand's help."""
    try:
        assert load_result(folder).signals()
    except InputError:
        check_absent(folder, force=False)
    check_absent(folder, force=True)


def _check_file(path: Path, made: Path) -> None:
    found = path.read_bytes()
    if found == NOTES.encode():
        return
    if path.name in CHANGING:
        assert found.rstrip().endswith(made.read_bytes().rstrip()[-7:])
    else:
        assert found == made.read_bytes()
