"""What `identify` prints first: one screen with the identifiable parameters."""

import json
import re
from pathlib import Path

import pytest
from random_motions import random_motion
from running import LINEAR, Orbident, written

from orbident.recordings.recording import Recording
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate

LINES, COLUMNS = 24, 80
"""Size of a terminal, as it opens nearly everywhere."""

LONG = (
    "4 m(link3) + Ixx(link1) - Iyy(link1) + Izz(link2) + Izz(link3) "
    "- sigma_4^2/M - sigma_5^2/M\n"
)
"""The formula of a `pi`."""


LINE = re.compile(r"(?:^|\s)(M|(?:sigma|iota|pi|phi)_\d+) +(-?\d.*)")
"""A symbol, before numbers."""


def rows(words: str) -> dict[str, list[str]]:
    """The numbers of each line of a table, by the parameter's symbol."""
    lines = [LINE.search(line) for line in words.splitlines()]
    return {found[1]: found[2].split() for found in lines if found}


@pytest.mark.parametrize("robot", ["paper-spatial", "cepheus-like", "dual-arm"])
def test_one_screen(
    orbident: Orbident, robot: str, flight: Recording, table_run: Recording
):
    """The table has CAD and sigmas; 14 joints have 108 parameters."""
    momentum = "at-rest" if robot == "cepheus-like" else "unknown"
    if robot == "dual-arm":
        described = load_robot(robot)
        recorded = simulate(described, random_motion(described))
    else:
        recorded = table_run if robot == "cepheus-like" else flight
    written(recorded, "r.parquet")
    ran = orbident(
        *("identify", robot, "r.parquet", *LINEAR, "--initial-momentum", momentum),
        *("-o", "run", "--json", "found.json"),
    )
    assert ran.status == 0
    lines = ran.out.splitlines()
    # One line is the prompt's.
    assert len(lines) < LINES
    assert max(map(len, lines)) <= COLUMNS
    shown = rows(ran.out)
    base = json.loads(Path("found.json").read_text())["base"]
    assert next(iter(shown)) == "M"
    assert len(shown) == min(len(base["names"]), 9)
    for name, numbers in shown.items():
        k = base["names"].index(name)
        value, std, cad = base["values"][k], base["std"][k], base["nominal"][k]
        assert float(numbers[0]) == pytest.approx(value, rel=1e-5, abs=std)
        assert float(numbers[1]) == pytest.approx(std, rel=0.1)
        assert float(numbers[2]) == pytest.approx(cad, rel=1e-5, abs=std)
        off = (value - cad) / std
        assert float(numbers[3]) == pytest.approx(off, rel=0.06, abs=0.06)


def test_all_is_shown_on_request(orbident: Orbident, flight: Recording):
    written(flight, "r.csv")
    run = ("identify", "paper-spatial", "r.csv")
    words = orbident(*run).done().out
    assert "--all" in words
    assert "pi_1 " not in words
    words = orbident(*run, "--all").done().out
    assert list(rows(words)) == [
        "M",
        *(f"sigma_{k}" for k in range(1, 6)),
        *(f"iota_{k}" for k in range(1, 13)),
        *(f"phi_{k}" for k in range(1, 6)),
        *(f"pi_{k}" for k in range(1, 20)),
    ]
    assert "843.1" in words
    # Nothing is cut short, whatever the width of a pipe.
    assert "…" not in words
    assert LONG in words
    # Routes and how far they are apart; the last one is compared with nothing.
    *_, eq32, last = [line.split() for line in words.splitlines() if "  M by" in line]
    assert eq32[:4] == ["M", "by", "Eq.", "32"]
    assert abs(float(eq32[-1])) < 5
    assert last[:4] == ["M", "by", "maximum", "likelihood"]
    assert last[-1] == "-"


def test_what_limits_it_is_on_the_screen_too(orbident: Orbident):
    robot = load_robot("paper-spatial")
    motion = random_motion(robot, duration=20.0)
    written(simulate(robot, motion, noise="sensors", seed=1), "r.csv")
    run = ("identify", "paper-spatial", "r.csv", "--json", "found.json")
    words = orbident(*run, "-o", "run").done().out
    assert len(words.splitlines()) < LINES
    assert max(map(len, words.splitlines())) <= COLUMNS
    assert "\nM is limited by noise of the " in words
    found = json.loads(Path("found.json").read_text())["budget"]
    assert found["parameters"][0] == "M"
    assert sum(found["shares"][0]) == pytest.approx(1.0)
    words = orbident(*run, "--all").done().out
    *_, table = words.partition("budget: what the deviation of each parameter")
    firsts = [line.split()[0] for line in table.splitlines() if line[1:2].isalpha()]
    assert [name for name in found["parameters"] if name not in firsts] == []


@pytest.mark.parametrize("more", [(), pytest.param(("--all",), marks=pytest.mark.slow)])
def test_a_refused_result_has_no_numbers(
    orbident: Orbident, flight: Recording, more: tuple[str, ...]
):
    written(flight, "r.csv", drop=["velocity", "position"])
    linear = "--method", "least-squares"
    ran = orbident("identify", "paper-spatial", "r.csv", *linear, *more, "-o", "run")
    assert ran.status == 1
    assert rows(ran.out) == {}
    assert "kg" not in ran.out
    assert "velocity" in ran.out
    report = Path("run/report.html").read_text()
    assert 'id="parameters"' not in report
    assert 'id="masses"' not in report
