"""The filter with constant tables and static memory: Python's numbers, to the bit."""

import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
from flight_tables import WINDOW, tables
from processes import finished
from random_motions import random_motion

from orbident.estimation.recursive.changes import Detector
from orbident.estimation.recursive.filter import Extended
from orbident.estimation.recursive.given import given_of
from orbident.estimation.recursive.prior import cad_prior
from orbident.preprocessing.samples import samples_of
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate

HERE = Path(__file__).parent
HEADERS = HERE.parents[3] / "src" / "core" / "include"
COMPILER = shutil.which("g++")
FLAGS = ("-std=c++17", "-O2", "-ffp-contract=off", "-fno-exceptions", "-fno-rtti")
WARNINGS = ("-Werror", "-Wall", "-Wextra", "-Wconversion", "-Wdouble-promotion")


def eigen() -> Path | None:
    """Eigen's headers, where the core was built with them."""
    folders = (Path(folder) / "cmeel.prefix/include/eigen3" for folder in sys.path)
    return next((folder for folder in folders if folder.is_dir()), None)


@pytest.mark.skipif(COMPILER is None, reason="there is no g++ to compile with")
@pytest.mark.skipif(eigen() is None, reason="Eigen's headers are not installed")
@pytest.mark.parametrize("name", ["paper-spatial", "cepheus-like"])
def test_a_flight_computer_gets_the_same_bits(tmp_path: Path, name: str):
    robot = load_robot(name)
    start = "spun up" if robot.motion == "planar" else "turning"
    motion = random_motion(robot, duration=12.0, start=start)
    samples = samples_of(robot, simulate(robot, motion, rate=10.0, noise="sensors"))
    t, every, noise = given_of(robot, samples)
    # One sample without the velocity.
    every[5, -6:-3] = np.nan
    kalman, prior = Extended.of(robot, noise), cad_prior(robot)
    (tmp_path / "tables.inc").write_text(tables(robot, kalman, prior, t, every))
    program = tmp_path / "flight"
    paths = [f"-I{HEADERS}", f"-isystem{eigen()}", f"-I{tmp_path}"]
    source = HERE / "filter_in_flight.cpp"
    build = [str(COMPILER), *FLAGS, *WARNINGS, *paths, str(source), "-o", str(program)]
    built = finished(*build)
    assert (built.returncode, built.stderr) == (0, "")
    run = finished(program)
    found = [list(map(float.fromhex, row.split())) for row in run.stdout.splitlines()]

    state = kalman.begun(prior, every[0], None)
    watch = Detector(kalman.rows, window=WINDOW).start()
    result = kalman.core.run(state.core, watch, np.inf, t, every)
    assert result[0].held_in_beta == (name == "paper-spatial")
    beta, tests = result[4], result[6]
    np.testing.assert_array_equal(found, np.column_stack([beta, tests[:, 2]]))
