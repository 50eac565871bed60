"""A recording that is good until something happens."""

import re
from dataclasses import replace

import numpy as np
import pytest
from captured_bodies import CapturedBody, holding, simulate_change
from cause_problems import clean, problem_with
from random_motions import random_motion

from orbident.diagnosis.events import event, plain_change
from orbident.estimation.momentum_problem import momentum_problem


@pytest.mark.slow
def test_a_position_that_drifts_from_the_middle_on():
    later = np.maximum(np.arange(301) - 150, 0)
    happened = event(problem_with({"position.y": lambda x: x + 1e-3 * later[: x.size]}))
    assert happened is not None
    assert "the position and the other instruments do not agree" in happened.fact
    assert "between t = " in happened.fact


def test_joints_of_the_other_sign_disagree_with_everything():
    names = clean().robot.joint_names
    wrong = {f"joint.{name}.position": lambda q: -q for name in names}
    assert event(problem_with(wrong)) is None


def test_a_capture_is_plain():
    """Half of the last link's mass, at a third of the time; bodies may be anything."""
    robot = replace(clean().robot, structure={})
    mass = robot.theta[-1, 0] / 2
    load = CapturedBody(mass, np.array([0.1, 0.2, 0.1]), 0.1 * mass * np.eye(3))
    motion = random_motion(
        robot, seed=1, duration=40.0, wheel_speed=100.0, start="turning"
    )
    seen = simulate_change(robot, holding(robot, load), motion, 13.05, seed=2)
    (found,) = plain_change(momentum_problem(robot, seen, "unknown", lambda _: None))
    assert re.search(r"between t = 12\.\d+ and 1[34](\.\d+)? s", found.reason)
    assert "the robot changed, by a capture or a release" in found.reason


def test_a_good_recording_shows_no_change():
    assert plain_change(problem_with()) == []
