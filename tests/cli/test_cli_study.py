"""`study`: the studies with noise, and what they leave behind.

`pytest -m long tests/cli/test_cli_study.py` runs that of a real table.
"""

import json
import signal
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from processes import LIMIT, started
from running import LINEAR, Orbident

PLANAR_FILES = {
    "trajectory.yaml",
    "identification.csv",
    "burn.csv",
    "validation.csv",
    "run",
    "report.html",
    *(f"fig{k:02}.{kind}" for k in range(6, 14) for kind in ("csv", "png", "svg")),
}
CONTROL_FILES = {"trajectory.yaml", "recording.csv", "report.html", "run"}


@pytest.mark.slow
def test_planar(orbident: Orbident):
    """Its recordings are what `identify`, `weigh` and `validate` take."""
    ran = orbident("study", "planar", "-o", "kept", "--json", "study.json").done()
    for words in (
        "Table 6 without noise",
        "Eq. 47's run predicted",
        "all samples (weigh)",
        "two slopes (paper)",
        "written: kept",
    ):
        assert words in ran.out
    assert {path.name for path in Path("kept").iterdir()} == PLANAR_FILES
    page = Path("kept/report.html").read_text()
    for words in ("Table 6 and the burn", "the study&#39;s aim is met", "Fig. 13."):
        assert words in page
    assert page.count("data:image/svg+xml") == 8
    study = json.loads(Path("study.json").read_text())
    # As the study itself is tested.
    assert all(abs(row["error_percent"]) < 5e-3 for row in study["parameters"])
    mass = orbident("weigh", "cepheus-like", "kept/burn.csv", "--json", "-").done()
    assert mass.json["mass"] == study["weigh"]["mass"]
    file = "kept/identification.csv"
    found = orbident(
        *("identify", "cepheus-like", file, "--initial-momentum", "at-rest"),
        *(*LINEAR, "--json", "-"),
    )
    assert found.done().json["status"] == "ok"
    scores = orbident("validate", "kept/run", "kept/validation.csv", "--json", "-")
    # The spline between samples.
    assert max(scores.done().json["nrmse"].values()) < 1e-6


@pytest.mark.long
def test_planar_with_noise(orbident: Orbident):
    """The numbers are those of `tests/paper`, the way that of the other study."""
    run = ("study", "planar", "--noise", "paper", "--seeds", 2, "--seed", 3)
    run = *run, *LINEAR
    words = orbident(*run, "--json", "study.json").done().out
    assert "2 seeds" in words
    assert "by the paper's method" in words
    assert "by least-squares" in words
    study = json.loads(Path("study.json").read_text())
    assert study["seeds"] == 2
    (M,) = (row for row in study["parameters"] if row["name"] == "M")
    # The project's aim.
    assert M["rms_error_percent"] < 0.5
    assert max(study["validation"]["rms_nrmse"].values()) < 0.02


@pytest.mark.parametrize(
    "name", ["burn.csv", "fig09.csv", "fig09.svg", "trajectory.yaml", "report.html"]
)
def test_planar_spares_what_is_there(orbident: Orbident, name: str):
    Path(name).write_text("precious")
    orbident("study", "planar", "-o", ".").refused(f"{name}: exists already")
    assert Path(name).read_text() == "precious"


@pytest.mark.slow
def test_spatial_with_noise(orbident: Orbident):
    run = ("study", "spatial", "--noise", "paper", "--seeds", 2)
    words = orbident(*run, "--json", "study.json").done().out
    assert "Table 4 with Section 3.5's noise" in words
    assert "2 seeds" in words
    assert "RMS error by the noise of one sensor alone" in words
    study = json.loads(Path("study.json").read_text())
    rows = {row["name"]: row for row in study["parameters"]}
    assert len(rows) == 25
    for row in rows.values():
        assert 0 < row["rms_error_percent"] <= row["worst_error_percent"]
    for sensor in study["rms_error_percent_by_sensor"]:
        assert f" {sensor} " in words


@pytest.mark.slow
def test_workers_change_no_number(orbident: Orbident):
    run = ("study", "spatial", "--noise", "paper", "--seeds", 2, *LINEAR)
    one, two = (
        orbident(*run, "--workers", workers, "--json", "-").done().json
        for workers in (1, 2)
    )
    assert one.pop("elapsed_s") > 0
    assert two.pop("elapsed_s") > 0
    assert one == two


def test_an_interrupt_ends_all_workers():
    run = ("study", "spatial", "--noise", "paper", "--seeds", 9999, "--workers", 2)
    with started(*run, *LINEAR) as process:
        workers = wait_for(lambda: at_work(process.pid), count=2)
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=LIMIT)
    assert (process.returncode, said) == (130, "orbident: interrupted\n")
    wait_for(lambda: [pid for pid in workers if not Path(f"/proc/{pid}").exists()], 2)


def at_work(pid: int) -> list[int]:
    """Child processes that have loaded the core."""
    children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    maps = {int(child): Path(f"/proc/{child}/maps").read_text() for child in children}
    return [child for child, text in maps.items() if "orbident/_core" in text]


def wait_for(some: Callable[[], list[int]], count: int) -> list[int]:
    """What there is as soon as there are so many."""
    end = time.monotonic() + LIMIT
    while len(found := some()) < count:
        assert time.monotonic() < end
        time.sleep(0.05)
    return found


@pytest.mark.long
def test_control(orbident: Orbident):
    ran = orbident("study", "control", "-o", "kept", "--json", "study.json").done()
    assert "times better with the identified model" in ran.out
    assert {path.name for path in Path("kept").iterdir()} == CONTROL_FILES
    study = json.loads(Path("study.json").read_text())
    errors = study["rms_error"]
    # The aim.
    for name in ("joints", "base"):
        assert errors["CAD"][name] > 5 * errors["identified"][name]


def test_seeds_without_noise_are_all_alike(orbident: Orbident):
    ran = orbident("study", "spatial", "--seeds", 3, "--json", "-")
    assert ran.status == 0
    assert ran.err == (
        "orbident: warning: --seeds 3: without noise all are alike, so 1 is run\n"
    )
    assert ran.json["seeds"] == 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("study", "spatial", "--noise", "loud"), "'--noise': 'loud'"),
        (("study", "planar", "--seeds", "0"), "'--seeds'"),
        (("study", "planar", "--seed", "-1"), "'--seed'"),
    ],
)
def test_wrong_usage(orbident: Orbident, arguments: tuple[str, ...], words: str):
    orbident(*arguments).refused(words)


@pytest.mark.long
def test_table(orbident: Orbident):
    """Half a minute."""
    ran = orbident(
        *("study", "table", "--seed", 1, "-o", "kept", "--json", "study.json")
    ).done()
    for words in ("worst parameter", "What acted", "pull.x", "written: kept"):
        assert words in ran.out
    kept = {path.name for path in Path("kept").iterdir()}
    assert kept == CONTROL_FILES | {"cut_offs"}
    assert "A real table" in Path("kept/report.html").read_text()
    study = json.loads(Path("study.json").read_text())
    paper, ours = (study["by_method"][name][-1] for name in ("paper", "ours"))
    assert abs(paper["error_percent"]) > 20 > 5 > abs(ours["error_percent"])
    # The environment is kept with the trajectory.
    assert "film_drag" in Path("kept/trajectory.yaml").read_text()
