"""What free floating conserves, worked out again body by body in plain numpy."""

from typing import NamedTuple

import numpy as np
import pytest
from obvious_momentum import quaternion_rotation, system_motion
from random_robots import (
    DUAL_ARM,
    random_planar_robot,
    random_robot,
    random_start,
    random_swing,
    random_wheels,
)

from orbident.robot.description import Robot, Wheel
from orbident.simulation.free_floating import (
    BaseState,
    FreeFloating,
    free_floating,
)

T = np.linspace(0.0, 10.0, 101)
# Sums of some tens of terms in float64, divided and multiplied by D; the worst
# observed is 2e-15.
ROUNDING = 1e-12
Z = np.array([0.0, 0.0, 1.0])


class Run(NamedTuple):
    robot: Robot
    start: BaseState
    floated: FreeFloating


ROBOTS = {
    "spatial": random_robot(1, DUAL_ARM, prismatic=(4,)),
    "spatial-held": random_robot(2, DUAL_ARM, (1,), random_wheels(2, ("held",) * 3)),
    "spatial-free": random_robot(3, DUAL_ARM, (), random_wheels(3, ("free",) * 3)),
    "spatial-both": random_robot(4, DUAL_ARM, (), random_wheels(4, ("free", "held"))),
    "planar": random_planar_robot(5, DUAL_ARM, prismatic=(1, 5)),
    "planar-held": random_planar_robot(6, DUAL_ARM, (), (Wheel("rw", Z, 0.1),)),
    "planar-free": random_planar_robot(7, DUAL_ARM, (), (Wheel("rw", Z, 0.1, "free"),)),
}


@pytest.fixture(scope="module", params=ROBOTS)
def run(request) -> Run:
    robot = ROBOTS[request.param]
    start = random_start(8, robot)
    motion = random_swing(9, len(robot.joints))
    return Run(robot, start, free_floating(robot, motion, T, start, 1e-8))


def test_angular_momentum_about_the_cm(run):
    """`R_0 (h_rs + A_rw qd_rw) = h_cm` at every sample (Eq. 2)."""
    robot, _, ours = run
    axes = [2] if robot.motion == "planar" else [0, 1, 2]
    for k in range(T.size):
        h = system_motion(robot, ours.q[k], ours.qd[k], ours.w[k]).h_rs
        for wheel, qd_rw in zip(robot.wheels, ours.qd_rw[k], strict=True):
            h = h + wheel.axis * wheel.inertia * qd_rw
        error = quaternion_rotation(ours.attitude[k]) @ h - ours.h_cm
        assert np.linalg.norm(error[axes]) < ROUNDING * np.linalg.norm(ours.h_cm)


def test_the_start_is_kept(run):
    """The first sample is the state that was given."""
    robot, start, ours = run
    np.testing.assert_allclose(ours.w[0], start.angular_velocity, atol=ROUNDING)
    np.testing.assert_allclose(ours.v_S[0], start.velocity, atol=ROUNDING)
    np.testing.assert_array_equal(ours.attitude[0], start.attitude)
    np.testing.assert_array_equal(ours.r_S[0], np.zeros(3))
    # Spin minus what was added to it: 1e-16 of 200 rad/s.
    np.testing.assert_allclose(ours.qd_rw[0], start.wheel_speed, rtol=1e-13)
    assert ours.qd_rw.shape == (T.size, len(robot.wheels))


def test_wheels_keep_their_speed(run):
    """A held wheel keeps the relative speed, a free one the absolute one."""
    for wheel, qd_rw in zip(run.robot.wheels, run.floated.qd_rw.T, strict=True):
        kept = qd_rw
        if wheel.mode == "free":
            kept = qd_rw + run.floated.w @ wheel.axis
        np.testing.assert_allclose(kept, kept[0], rtol=ROUNDING)


def test_system_cm_moves_straight_on(run):
    """`r_S + R_0 r_cm` is linear in time, and `v_S` is its own share of `v_cm`."""
    robot, _, ours = run
    r_cm, v_cm = [], []
    for k in range(T.size):
        R_WB = quaternion_rotation(ours.attitude[k])
        total = system_motion(robot, ours.q[k], ours.qd[k], ours.w[k])
        r_cm.append(ours.r_S[k] + R_WB @ total.first_moment / robot.mass)
        v_cm.append(ours.v_S[k] + R_WB @ total.linear / robot.mass)
    # Metres and metres a second, all of the order of 1.
    straight = r_cm[0] + np.multiply.outer(T, ours.v_cm)
    np.testing.assert_allclose(r_cm, straight, atol=ROUNDING)
    np.testing.assert_allclose(v_cm, np.tile(ours.v_cm, (T.size, 1)), atol=ROUNDING)


def test_v_S_is_the_rate_of_r_S(run):
    """Position comes from the attitude, velocity from the rates: one fits the other."""
    t = np.linspace(0.0, 0.02, 9)
    motion = random_swing(9, len(run.robot.joints))
    ours = free_floating(run.robot, motion, t, run.start, 1e-12)
    weights = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105])
    weights = np.append(weights, -1 / 280)
    # The eighth-order difference at 2.5 ms is exact; rounding is 1e-16 / 2.5e-3.
    rate = weights @ ours.r_S / (t[1] - t[0])
    np.testing.assert_allclose(rate, ours.v_S[4], atol=1e-11)


def test_planar_motion_stays_in_the_plane():
    ours = free_floating(
        ROBOTS["planar"],
        random_swing(9, 6),
        T,
        random_start(8, ROBOTS["planar"]),
    )
    np.testing.assert_array_equal(ours.w[:, :2], 0.0)
    np.testing.assert_array_equal(ours.attitude[:, :2], 0.0)
    # What holds the robot in its plane takes up the other two.
    np.testing.assert_array_equal(ours.h_cm[:2], 0.0)
    # Sums that cancel exactly in real numbers.
    np.testing.assert_allclose(ours.v_S[:, 2], 0.0, atol=1e-14)
    np.testing.assert_allclose(ours.r_S[:, 2], 0.0, atol=1e-14)
