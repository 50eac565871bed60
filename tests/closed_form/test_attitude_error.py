"""The attitude against references that know nothing of its integrator."""

from typing import Literal

import numpy as np
import pytest
from obvious_momentum import quaternion_rotation, system_motion
from random_robots import (
    random_planar_robot,
    random_robot,
    random_start,
    random_swing,
    random_wheels,
)
from scipy.integrate import quad, solve_ivp

from orbident.robot.description import Robot, Wheel
from orbident.simulation.free_floating import BaseState, free_floating

PARENTS = (0, 1, 0)
MOTION = random_swing(2, len(PARENTS))
T = np.linspace(0.0, 3.0, 13)
SPATIAL = random_robot(1, PARENTS, (1,), random_wheels(1, ("held", "free")))
START = random_start(3, SPATIAL, rate=1.0)


def base_rate(robot: Robot, h_B: np.ndarray, spin: np.ndarray, t: float):
    """`w` of `h_B = D w + D_q qd + A_rw qd_rw`, with `D` found from unit rates."""
    q, qd, _ = MOTION.at(np.array(t))
    still = np.zeros_like(qd)
    D = np.array([system_motion(robot, q, still, e).h_rs for e in np.eye(3)]).T
    h = h_B - system_motion(robot, q, qd, np.zeros(3)).h_rs
    for wheel, kept in zip(robot.wheels, spin, strict=True):
        h = h - wheel.inertia * wheel.axis * kept
        if wheel.mode == "free":
            D = D - wheel.inertia * np.outer(wheel.axis, wheel.axis)
    if robot.motion == "planar":
        return np.array([0.0, 0.0, h[2] / D[2, 2]])
    return np.linalg.solve(D, h)


def kept_by(robot: Robot, start: BaseState):
    """Momentum in base axes and the spin that each wheel keeps, at the start."""
    q, qd, _ = MOTION.at(np.array(0.0))
    w = start.angular_velocity
    h = system_motion(robot, q, qd, w).h_rs
    spin = start.wheel_speed.copy()
    for k, wheel in enumerate(robot.wheels):
        h = h + wheel.inertia * wheel.axis * start.wheel_speed[k]
        spin[k] += wheel.axis @ w if wheel.mode == "free" else 0.0
    return h, spin


@pytest.fixture(scope="module")
def reference() -> np.ndarray:
    """Rotation matrices by an eighth-order integrator of `R_dot = R [w]x`."""
    h_B, spin = kept_by(SPATIAL, START)
    R_0 = quaternion_rotation(START.attitude)
    h_cm = R_0 @ h_B

    def rate(t, flat):
        R = flat.reshape(3, 3)
        w = base_rate(SPATIAL, R.T @ h_cm, spin, t)
        return np.cross(R, w).ravel()

    solved = solve_ivp(
        rate, (0, T[-1]), R_0.ravel(), "DOP853", t_eval=T, rtol=1e-13, atol=1e-13
    )
    return solved.y.T.reshape(-1, 3, 3)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-5, 1e-7, 1e-9])
def test_reported_error_is_the_true_one(reference, tolerance):
    ours = free_floating(SPATIAL, MOTION, T, START, tolerance)
    R = np.array([quaternion_rotation(x) for x in ours.attitude])
    # The chordal distance of two rotations is sqrt(2) times a small angle.
    true = np.linalg.norm(R - reference, axis=(1, 2)).max() / np.sqrt(2)
    assert ours.attitude_error < tolerance
    # Richardson's estimate is right to leading order in the step; observed: 1.002 to
    # 1.008.
    assert 0.95 < ours.attitude_error / true < 1.05


@pytest.mark.parametrize("mode", ["held", "free"])
def test_planar_attitude_is_a_quadrature(mode: Literal["held", "free"]):
    """In the plane the rate does not depend on the attitude: it is `int w dt`."""
    wheel = Wheel("rw", np.array([0.0, 0.0, 1.0]), 0.1, mode)
    robot = random_planar_robot(4, PARENTS, (1,), (wheel,))
    start = random_start(5, robot)
    h_B, spin = kept_by(robot, start)
    ours = free_floating(robot, MOTION, T, start, tolerance=1e-10)
    angle = 2 * np.arctan2(ours.attitude[:, 2], ours.attitude[:, 3])
    for k in range(T.size - 1):
        turned, _ = quad(
            lambda t: base_rate(robot, h_B, spin, t)[2],
            T[k],
            T[k + 1],
            epsabs=1e-13,
            epsrel=1e-13,
        )
        difference = angle[k + 1] - angle[k] - turned
        # Modulo a turn of the angle. Both ends are within the tolerance.
        assert abs(np.arctan2(np.sin(difference), np.cos(difference))) < 2e-10
