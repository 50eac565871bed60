"""Momentum changes as what acts from outside says, on any body (Eq. 15):

dh/dt = R_0 sum (n + (p - r_cm) x F),   M dv_cm/dt = R_0 sum F
"""

import numpy as np
import pytest
from flying_robots import moving_start, waving
from obvious_momentum import body_motion, quaternion_rotation
from random_robots import DUAL_ARM, random_robot, random_wheels
from scipy.spatial.transform import Rotation

from orbident import _core
from orbident.robot.description import Robot
from orbident.simulation.flight import (
    Hold,
    WrenchPoint,
    commanded,
    integrate,
    vehicle_of,
)
from orbident.simulation.free_floating import rate_law, step_nodes
from orbident.simulation.free_flying import free_flying

ROBOT = random_robot(3, DUAL_ARM, (4,), random_wheels(1, ("free", "held")))
END, STEPS = 2.0, 4000


def flown(robot: Robot, points, wrenches):
    """Joints wave, wheels coast; the wrenches are constant in base axes.

    With the weights of Simpson's rule over the steps' starts.
    """
    t = np.linspace(0.0, END, STEPS + 1)
    nodes = np.stack(
        [t, np.append(t[:-1] + np.diff(t) / 2, END), np.append(t[1:], END)]
    )
    joints, command = waving(2, 6), Hold(np.zeros(6))

    def at(some):
        constant = np.tile(wrenches, (len(some), 3, 1, 1))
        return commanded(robot, command, (joints, None), some, constant)

    first = free_flying(robot, t[:1], moving_start(8, robot), command, joints)
    R_WB = quaternion_rotation(first.attitude[0])
    start = np.concatenate(
        [
            *(first.r_cm, first.attitude, first.q, first.q_rw),
            *(first.v_cm @ R_WB, first.w, first.qd, first.qd_rw),
        ],
        axis=1,
    )[0]
    shown = integrate(
        vehicle_of(robot, joints, None, None, points),
        start,
        nodes.T,
        at,
        np.ones(STEPS + 1, dtype=bool),
    )
    weights = np.full(STEPS + 1, 2.0)
    weights[1::2] = 4.0
    weights[[0, -1]] = 1.0
    return shown, weights * END / STEPS / 3


@pytest.mark.parametrize("bodies", [(0,), (6, 2)], ids=["base", "two links"])
def test_a_wrench_on_any_body_is_momentum(bodies):
    random = np.random.default_rng(len(bodies))
    points = [WrenchPoint(body, random.standard_normal(3)) for body in bodies]
    wrenches = random.standard_normal((len(bodies), 6))
    seen, weights = flown(ROBOT, points, wrenches)
    dh, dp = np.zeros((2, STEPS + 1, 3))
    zero = np.zeros(6)
    for k, (q, x_WB, r_cm, r_S) in enumerate(
        zip(seen.q, seen.x_WB, seen.r_cm, seen.r_S, strict=True)
    ):
        R_WB = quaternion_rotation(x_WB)
        for (body, point), wrench in zip(points, wrenches, strict=True):
            at = body_motion(ROBOT, body, q, zero, np.zeros(3))
            F, n = R_WB @ wrench[:3], R_WB @ wrench[3:]
            arm = r_S + R_WB @ (at.d + at.R @ point) - r_cm
            dh[k] += n + np.cross(arm, F)
            dp[k] += F
    gained_h = seen.h_cm[-1] - seen.h_cm[0]
    gained_p = ROBOT.mass * (seen.v_cm[-1] - seen.v_cm[0])
    assert np.linalg.norm(gained_h) > 0.5
    # Simpson's rule and RK4 at 0.5 ms: h^4 is 6e-14; wheels turn at 200 rad/s.
    np.testing.assert_allclose(gained_h, weights @ dh, atol=1e-9)
    np.testing.assert_allclose(gained_p, weights @ dp, atol=1e-9)


def test_attitude_under_a_constant_torque():
    """A ball of inertia I turns by `(h t + tau t^2 / 2) / I` about the torque."""
    I, h, torque = 2.0, 0.8, 0.3
    axis = np.array([0.6, 0.0, 0.8])
    t = np.linspace(0.0, 3.0, 31)
    nodes = step_nodes(t, 4)
    law = rate_law(
        np.tile(I * np.eye(3), (nodes.size, 1, 1)), np.zeros((nodes.size, 3)), False
    )
    h_cm = np.multiply.outer(h + torque * nodes, axis)
    start = Rotation.from_rotvec([0.3, -0.2, 0.5])
    x_WB, _ = _core.attitudes(*law, h_cm, start.as_quat(), t, 4)
    angle = (h * t + torque * t**2 / 2) / I
    expected = Rotation.from_rotvec(np.multiply.outer(angle, axis)) * start
    apart = (Rotation.from_quat(x_WB).inv() * expected).magnitude()
    # RK4: (w dt / 2)^5 / 120 a step, w dt = 0.02, 120 steps.
    assert apart.max() < 1e-9
