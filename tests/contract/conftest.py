"""The robot and the recording that every method is tried on."""

import pytest
from random_motions import random_motion

from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot("paper-spatial")


@pytest.fixture(scope="module")
def recording(robot: Robot) -> Recording:
    return simulate(robot, random_motion(robot))
