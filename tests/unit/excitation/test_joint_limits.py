from dataclasses import replace

import numpy as np
import pytest

from orbident.errors import InputError
from orbident.excitation.conditions import conditions_for, limits_of
from orbident.excitation.joint_limits import (
    check_ends,
    inner_point,
    joint_motions,
    polytope_of,
)
from orbident.robot.joint_schema import coupled_joints
from orbident.robot.robot_file import load_robot

NAMES = ("joint1", "joint2")
FREE = dict(enumerate(NAMES))
STILL = np.zeros((2, 3))


def motions_to(end, duration, limits):
    """From rest at zero, with three harmonics."""
    robot = load_robot("cepheus-like")
    given = conditions_for(robot, duration, 3, limits)
    return joint_motions(replace(given, end=end), coupled_joints(robot), 101)


@pytest.fixture(scope="module")
def robot():
    return load_robot("cepheus-like")


def test_limits_are_the_robots(robot):
    limits = limits_of(robot, base_rate=0.5)
    np.testing.assert_array_equal(limits.position, [[-1.05, 2.5], [-2.09, 1.4]])
    np.testing.assert_array_equal(limits.velocity, [0.7, 0.5])
    assert np.isinf(limits.acceleration).all()
    assert limits.base_rate == 0.5
    assert np.isinf(limits.wheel_speed)


def test_a_joint_with_one_stop(robot):
    one = replace(robot.joints[0], position=(-1.05, np.inf))
    limits = limits_of(replace(robot, joints=(one, robot.joints[1])))
    np.testing.assert_array_equal(limits.position[0], [-1.05, 2 * np.pi - 1.05])


def test_a_joint_without_a_velocity_limit_is_refused(robot):
    joints = (robot.joints[0], replace(robot.joints[1], velocity=None))
    with pytest.raises(InputError, match="'joint2': velocity limit: found None; give"):
        limits_of(replace(robot, joints=joints))


def test_a_robot_without_joints_is_refused(robot):
    with pytest.raises(InputError, match="joints and thrusters: found none"):
        limits_of(replace(robot, joints=(), thrusters=()))


@pytest.mark.parametrize("found", [0.0, 1e-300, 1e160, float("nan")])
def test_a_limit_that_cannot_be_is_refused(robot, found):
    # The square of 1e-300 is zero, and that of 1e160 is no number.
    with pytest.raises(InputError, match="base rate limit: found"):
        limits_of(robot, base_rate=found)


def test_limits_of_sizes_too_different_are_refused(robot):
    limits = limits_of(robot, acceleration=1e-15)
    motions = motions_to(STILL, 1e-9, limits)
    with pytest.raises(InputError, match="'joint1': no motion could be found"):
        inner_point(polytope_of(motions, limits), limits, FREE)


def test_slack_is_the_distance_from_the_limits(robot):
    """Against the histories themselves, row by row."""
    limits = limits_of(robot, acceleration=2.0)
    motions = motions_to(STILL, 20.0, limits)
    polytope = polytope_of(motions, limits)
    y = 0.3 * np.random.default_rng(0).standard_normal((2, 6))
    q, qd, qdd = (
        offset[1:-1] + basis[1:-1] @ (limits.velocity[:, None] * y).T
        for offset, basis in zip(motions.offset, motions.basis, strict=True)
    )
    lower, upper = limits.position.T
    half = (upper - lower) / 2
    # Rows are relative to limits that are kept back by 5e-4 of their size.
    expected = [(upper - q) / half, (q - lower) / half]
    expected += [1 - qd / limits.velocity, 1 + qd / limits.velocity]
    expected += [1 - qdd / 2.0, 1 + qdd / 2.0]
    slack = polytope.slack(y)
    np.testing.assert_allclose(slack.T, np.concatenate(expected), rtol=0, atol=2e-3)


def test_reach_ends_at_a_limit(robot):
    limits = limits_of(robot)
    motions = motions_to(STILL, 20.0, limits)
    polytope = polytope_of(motions, limits)
    y, step = np.zeros((2, 6)), np.random.default_rng(0).standard_normal((2, 6))
    there = y + polytope.reach(y, step)[:, None] * step
    # Zero but for rounding of numbers of the order of one.
    np.testing.assert_allclose(polytope.slack(there).min(axis=1), 0.0, atol=1e-13)


def test_too_short_a_duration_names_the_limit_and_by_how_much(robot):
    limits = limits_of(robot)
    end = STILL.copy()
    end[0, 0] = 2.0
    # 2 rad in 2 s: no faster than 0.7 rad/s leads only 1.4 rad far.
    motions = motions_to(end, 2.0, limits)
    with pytest.raises(InputError, match=r"'joint1': velocity: .* 0\.7 .* by \d+ %"):
        inner_point(polytope_of(motions, limits), limits, FREE)


def test_an_inner_point_is_inside(robot):
    limits = limits_of(robot)
    end = STILL.copy()
    end[0, 0] = 2.0
    motions = motions_to(end, 6.0, limits)
    polytope = polytope_of(motions, limits)
    assert polytope.slack(inner_point(polytope, limits, FREE)).min() > 0


@pytest.mark.parametrize(
    ("state", "words"),
    [
        ((3.0, 0.0, 0.0), "position at the start: found 3, 0.5"),
        ((2.5, 0.0, 0.0), "position at the start: found 2.5"),
        ((0.0, -0.9, 0.0), "velocity at the start: found -0.9, 0.2"),
    ],
)
def test_a_start_outside_is_refused(robot, state, words):
    start = STILL.copy()
    start[0] = state
    with pytest.raises(InputError, match=f"'joint1': {words}"):
        check_ends(NAMES, limits_of(robot), start, STILL)
