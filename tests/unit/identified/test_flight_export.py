"""The filter as a flight computer has it: Python's numbers, to the bit.

What takes minutes is behind `long`; ORBIDENT_FUZZED says how many samples are spoiled:

    ORBIDENT_FUZZED=100000000 pytest -m long -s -k flight tests/unit/identified
"""

import os
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from flight_builds import (
    CHECKS,
    WARNINGS,
    exported,
    exported_of,
    library,
    needs_compilers,
    one_joint,
    program,
    ran,
)
from processes import finished
from random_robots import random_parents, random_robot, random_wheels

from orbident.errors import InputError
from orbident.identified.flight_export import SOURCES, check_empty
from orbident.robot.description import GearedRotor
from orbident.robot.robot_file import load_robot
from orbident.robot.sensor_schema import TorqueSpec, declared_sensors

pytestmark = needs_compilers

ROBOTS = ("paper-spatial", "cepheus-like", "dual-arm")
LIBRARY = {"memcpy", "memmove", "memset", "sin", "cos", "sincos"}
"""All that the filter needs from elsewhere."""


@pytest.fixture(scope="module")
def spatial(tmp_path_factory: pytest.TempPathFactory) -> Path:
    # At so low a rate the detector is wrong at times: it shows what follows a change.
    folder = tmp_path_factory.mktemp("flight") / "f"
    return exported(folder, "paper-spatial", 16.0, 10.0)


@pytest.fixture(scope="module")
def built(spatial: Path) -> Path:
    return library(spatial)


@pytest.fixture(scope="module")
def checks(spatial: Path, built: Path) -> Path:
    return program(CHECKS, spatial, built)


def agreed(folder: Path, filter_: Path) -> tuple[int, int]:
    """How many steps the replayed program says agree, and how many changes it saw."""
    told = ran(program(folder / "main.c", folder, filter_))
    found = re.match(r"(\d+) of \1 steps agree to the last bit; .*: (\d+)\n", told)
    assert found, told
    return int(found[1]), int(found[2])


def test_a_flight_computer_gets_the_same_bits(spatial: Path, built: Path):
    told = ran(built.parent / "replay")
    found = re.match(r"(\d+) of (\d+) steps agree to the last bit; .*: (\d+)\n", told)
    assert found
    assert found[1] == found[2]
    assert int(found[3]) > 0


def test_a_single_different_bit_is_seen(spatial: Path, built: Path, tmp_path: Path):
    """As if the code had been compiled with contraction, or another libm."""
    golden = (spatial / "golden.h").read_text()
    start = golden.index("BETA")
    row = golden.index("p+", start)
    digit = "0" if golden[row - 1] != "0" else "1"
    (tmp_path / "golden.h").write_text(golden[: row - 1] + digit + golden[row:])
    for name in ("main.c", "robot.h"):
        (tmp_path / name).write_text((spatial / name).read_text())
    (tmp_path / "include").symlink_to(spatial / "include")
    run = finished(program(tmp_path / "main.c", tmp_path, built))
    assert run.returncode == 1
    steps = re.match(r"(\d+) of (\d+) steps agree", run.stdout)
    assert steps
    assert int(steps[1]) == int(steps[2]) - 1


def test_a_robot_with_rotors_and_torques(built: Path, tmp_path: Path):
    """Rotors are in the momentum, and torques are sensors."""
    robot = load_robot("paper-spatial")
    rotor = GearedRotor(100.0, 1e-4, 0.2)
    torques = robot.sensors.model_copy(update={"torques": TorqueSpec(std=0.1)})
    robot = replace(robot, rotors=dict.fromkeys(robot.joint_names, rotor))
    robots = {"without": robot, "with": replace(robot, sensors=torques)}
    for name, each in robots.items():
        exported_of(each, tmp_path / name, 12.0, 10.0)
        assert agreed(tmp_path / name, built)[0] > 100
    tables = [(tmp_path / name / "robot.h").read_text() for name in robots]
    assert [table.count("ROBOT_DRIVEN") for table in tables] == [0, 2]


def test_a_plane_robot(built: Path, tmp_path: Path):
    """One conserved component of the angular momentum, no scale and no hand-over."""
    folder = exported(tmp_path / "f", "cepheus-like", 12.0, 10.0)
    assert agreed(folder, built)[0] > 100


@pytest.mark.parametrize("joint", ["revolute", "prismatic"])
def test_a_robot_without_a_wheel(built: Path, tmp_path: Path, joint: str):
    """Nothing tells its scale; with an arm that slides the filter diverged once."""
    robot = one_joint(tmp_path, joint, wheel=False)
    assert agreed(exported(tmp_path / "f", robot, 16.0, 10.0), built)[0] > 100


def test_nothing_of_a_heap_or_an_exception(built: Path):
    symbols = ran("nm", "--undefined-only", "--format=just-symbols", built).split()
    needed = {name for name in symbols if not name.endswith(".o:")}
    assert needed <= LIBRARY


@pytest.mark.slow
def test_single_precision_compiles_without_a_double(spatial: Path):
    """The compiler warns of every number that would become a double."""
    paths = [f"-I{spatial}", f"-I{spatial / 'include'}", "-isystem", spatial / "eigen"]
    flags = ["-std=c++17", "-fsyntax-only", "-fno-exceptions", "-fno-rtti", *WARNINGS]
    ran("c++", *flags, "-DORBIDENT_REAL=float", *paths, spatial / "flight.cpp")


def test_codes_have_their_meanings(checks: Path):
    ran(checks, "refusals")


def test_a_state_goes_on_after_a_power_cycle(checks: Path):
    assert ran(checks, "restore", 1000) == "1000 restored\n"


def test_spoiled_samples_give_no_nan_without_a_code(checks: Path):
    told = ran(checks, "fuzz", 20_000, 1)
    assert all(int(n) > 0 for n in re.findall(r"(\d+) (?:counted|absurd|not)", told))


def test_a_folder_that_holds_something_is_not_touched(tmp_path: Path):
    check_empty(tmp_path)
    (tmp_path / "note").write_text("mine")
    for force in (False, True):
        with pytest.raises(InputError, match="something else than a filter"):
            check_empty(tmp_path, force)
    with pytest.raises(InputError, match="note: is a file; name a folder"):
        check_empty(tmp_path / "note")


def test_every_header_that_is_included_is_there(spatial: Path):
    """Ours; a missing one of Eigen would not compile."""
    there = {path.name for path in (spatial / "include/orbident").iterdir()}
    assert there < {path.name for path in (SOURCES / "include/orbident").iterdir()}
    assert {"flight.h", "information_filter.hpp", "scalar.hpp"} <= there


@pytest.mark.long
def test_20_recordings(built: Path, tmp_path: Path):
    """The recordings are of every bundled robot, with other motions and other noise."""
    for seed in range(20):
        name = ROBOTS[seed % 3]
        duration, rate = (30.0, 20.0) if name != "dual-arm" else (20.0, 20.0)
        folder = exported(tmp_path / f"{seed}", name, duration, rate, seed)
        steps, changes = agreed(folder, built)
        print(f"{name}, seed {seed}: {steps} steps agree, {changes} changes")


@pytest.mark.long
def test_20_random_robots(built: Path, tmp_path: Path):
    """Trees of one to six joints, a third of which slide; none to three wheels."""
    walk = {"angle_random_walk": 1e-5}
    fine = {"position": 1e-5}
    sensors = {"gyro": walk, "attitude": {"angle": 1e-5}, "position": {"std": 1e-4}}
    sensors |= {"joints": fine, "wheels": fine}
    for seed in range(20):
        random = np.random.default_rng(seed)
        joints = 1 + seed % 6
        slide = [k for k in range(joints) if random.uniform() < 1 / 3]
        robot = random_robot(
            seed,
            random_parents(random, joints),
            slide,
            random_wheels(seed, ["held" for _ in range(seed % 4)]),
            base=5.0,
        )
        robot = replace(robot, sensors=declared_sensors(sensors))
        folder = exported_of(robot, tmp_path / f"{seed}", 20.0, 20.0, seed)
        steps, changes = agreed(folder, built)
        print(f"{joints} joints, slide: {slide}, {seed % 4} wheels: {steps}, {changes}")


@pytest.mark.long
@pytest.mark.parametrize("scalar", ["double", "float"])
def test_many_spoiled_samples(tmp_path: Path, scalar: str):
    folder = exported(tmp_path / "f", one_joint(tmp_path), 16.0, 10.0)
    steps = int(os.environ.get("ORBIDENT_FUZZED", "1000000"))
    checks = program(CHECKS, folder, library(folder, scalar), scalar)
    print(scalar, ran(checks, "fuzz", steps, 2, limit=36_000.0))


@pytest.mark.long
@pytest.mark.parametrize("name", ["paper-spatial", "dual-arm"])
def test_float_and_times(built: Path, tmp_path: Path, name: str):
    """How far off single precision is, and how long the longest step takes."""
    rate = 50.0 if name == "paper-spatial" else 10.0
    folder = exported(tmp_path / "f", name, 40.0, rate)
    print(
        name, ran(program(folder / "main.c", folder, library(folder, "float"), "float"))
    )
    steps = 1_000_000 if name == "paper-spatial" else 20_000
    told = ran(program(CHECKS, folder, built), "times", steps, limit=3600.0)
    print(told)
    # Of a robot with few joints; that of many joints is far faster after the hand-over.
    ratio = re.search(r"ratio ([\d.]+)", told)
    assert ratio
    assert name == "dual-arm" or float(ratio[1]) <= 3
