"""What is known of passive joints beforehand, as equations."""

from dataclasses import replace

import numpy as np
import pytest
from random_robots import random_robot

from orbident.errors import InputError
from orbident.estimation.output_error.beforehand import carried_rows
from orbident.estimation.output_error.joint_laws import joint_laws
from orbident.estimation.solution import OUTSIDE
from orbident.model.kinematics import carried_inertia
from orbident.model.minimal_sets import minimal_sets
from orbident.preprocessing.wrenches import RecordedWrench
from orbident.robot.description import Passive, Robot

PASSIVE = {
    "joint2": Passive(0.5, inertia=0.05),
    "joint3": Passive(0.5, like="joint2"),
}

ERRORS = [f"joint.{k}.{what}" for k in PASSIVE for what in ("frequency", "damping")]


@pytest.fixture(scope="module")
def robot() -> Robot:
    return replace(random_robot(5, (0, 0, 0)), passive=PASSIVE)


def unexplained(robot: Robot, theta: np.ndarray, logarithms: list[float]) -> np.ndarray:
    """What is left of all rows, over their deviations."""
    sets = minimal_sets(robot)
    rows = carried_rows(robot, sets, ERRORS)
    at = np.concatenate([np.ones(OUTSIDE), sets.beta(theta), logarithms])
    return rows[:, -1] - rows[:, :-1] @ at


def test_what_is_known_holds_of_the_nominal_robot(robot):
    np.testing.assert_allclose(
        unexplained(robot, robot.theta, [0.1, 0.2, 0.1, 0.2]), 0.0, atol=1e-9
    )


def test_by_how_many_deviations_it_does_not(robot):
    """The first carries 10 % more: two deviations of 5 %, ten of those of one make."""
    theta = robot.theta.copy()
    theta[2] *= 1.1
    left = unexplained(robot, theta, [0.02, 0.0, 0.0, 0.3])
    np.testing.assert_allclose(left, [-2.0, 0.0, 10.0, 2.0, -3.0], atol=1e-9)


def test_what_is_exact_has_some_width(robot):
    exact = {name: each._replace(inertia=0.0) for name, each in PASSIVE.items()}
    rows = carried_rows(replace(robot, passive=exact), minimal_sets(robot), ERRORS)
    assert np.isfinite(rows).all()


def test_laws(robot):
    laws = joint_laws(robot, (), 1e-3)
    np.testing.assert_array_equal(laws.passive, [1.0, 2.0])
    rate = 2 * np.pi * 0.5
    np.testing.assert_allclose(laws.laws[0, :2], [rate**2, 2 * 0.01 * rate])
    np.testing.assert_array_equal(laws.laws[1, 4:], carried_inertia(robot, 2))


def test_one_that_carries_nothing_is_refused(robot):
    theta = robot.theta.copy()
    theta[3] = 0.0
    with pytest.raises(InputError, match="passive joint 'joint3' carries no inertia"):
        joint_laws(replace(robot, theta=theta), (), 1e-3)


def test_thrust_is_refused(robot):
    none = np.zeros((4, 3))
    torque = RecordedWrench("torquer", 0.0, none, none + 1.0, none)
    assert joint_laws(robot, (torque,), 1e-3)
    thrust = torque._replace(force=none + 1.0)
    with pytest.raises(InputError, match="joint 'joint2' is passive, and thrust"):
        joint_laws(robot, (torque, thrust), 1e-3)
