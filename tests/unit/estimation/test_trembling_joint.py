"""A joint that a controller holds trembles: it is held all the same."""

from dataclasses import replace

import numpy as np
import pytest
from random_motions import random_motion

from orbident.estimation.identify import identify
from orbident.model.minimal_sets import minimal_sets
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate

TREMBLE, HERTZ = 2e-3, 3.0
"""rad, and how often; encoders see 2.5e-5 rad."""
LIGHT = 1e-6
"""Part of its inertia that the last link has: then its tremble turns nothing."""


def with_light_hand(robot: Robot) -> Robot:
    theta = robot.theta.copy()
    theta[-1] *= LIGHT
    return replace(robot, theta=theta)


def flight(robot: Robot, seed: int) -> Recording:
    """The last joint is at 0.4 rad, and its encoder shows how it trembles there."""
    last = robot.joint_names[-1]
    motion = random_motion(robot, start_at={last: 0.4}, still=(last,))
    recording = simulate(robot, motion, noise="sensors", seed=seed)
    column = f"joint.{last}.position"
    tremble = TREMBLE * np.sin(2 * np.pi * HERTZ * recording.t)
    columns = {**recording.columns, column: recording.columns[column] + tremble}
    columns.pop(f"joint.{last}.velocity", None)
    return replace(recording, columns=columns)


@pytest.mark.parametrize("seed", range(3))
def test_what_trembles_unseen_is_held(seed):
    robot = with_light_hand(load_robot("paper-spatial"))
    result = identify(robot, flight(robot, seed))
    assert result.status == "ok"
    last = robot.joint_names[-1]
    assert any(f"'{last}' never moved" in words for words in result.warnings)
    errors = result.base.values - minimal_sets(robot).beta(robot.theta)
    ratios = (errors / result.base.std)[np.isfinite(result.base.std)]
    assert np.abs(ratios).max() < 5


@pytest.mark.slow
def test_what_trembles_and_shows_is_moved():
    robot = load_robot("paper-spatial")
    recording = flight(robot, 0)
    result = identify(robot, recording)
    assert not any("never moved" in words for words in result.warnings)
