"""The torque-free precession of an axisymmetric body, in closed form.

With inertia `C` about the axis `e` and `A` across it, about the CM:

    w = h / A - l e,  l = (C - A) / A  (w . e),     h = A w + (C - A) (w . e) e,

where `h` is constant in `W` and `l` is constant: the body turns steadily about `h` at
`|h| / A` while it spins about its own axis at `-l`.
"""

import numpy as np
import pytest
from obvious_momentum import quaternion_rotation, rotation
from random_robots import random_quaternion, random_unit_vector

from orbident.robot.description import Robot, Wheel
from orbident.robot.parameters import from_mass_com_inertia
from orbident.simulation.free_floating import BaseState, FreeFloating, free_floating

MASS, A = 40.0, 3.0
T = np.linspace(0.0, 20.0, 201)
TOLERANCE = 1e-10
# The reported error estimate is kept below the tolerance; it is an estimate, and 6000
# steps of rounding add up to some 1e-14.
ATTITUDE = 1.2 * TOLERANCE


class NoJoints:
    """The motion of a body without joints."""

    def at(self, t):
        none = np.zeros((t.size, 0))
        return none, none, none


class Body:
    """An axisymmetric body with its axis, CM and start chosen at random."""

    def __init__(self, C: float, seed: int):
        random = np.random.default_rng(seed)
        self.C, self.e = C, random_unit_vector(random)
        self.com = random.standard_normal(3)
        self.start = BaseState(
            angular_velocity=0.4 * random.standard_normal(3),
            attitude=random_quaternion(random),
            velocity=random.standard_normal(3),
            wheel_speed=np.zeros(0),
        )
        self.I = A * np.eye(3) + (C - A) * np.outer(self.e, self.e)

    def robot(self, wheels: tuple[Wheel, ...] = ()) -> Robot:
        return Robot(
            name="body",
            motion="spatial",
            bodies=("body",),
            joints=(),
            theta=from_mass_com_inertia(MASS, self.com, self.I)[None],
            feature_point=np.zeros(3),
            wheels=wheels,
        )

    def floated(self) -> FreeFloating:
        return free_floating(self.robot(), NoJoints(), T, self.start, TOLERANCE)

    def attitude(self, t: float) -> np.ndarray:
        """`R_WB`: about `h` in `W` after, about `e` in `B` before the first one."""
        R_0, w_0 = quaternion_rotation(self.start.attitude), self.start.angular_velocity
        h = R_0 @ self.I @ w_0
        size = float(np.linalg.norm(h))
        spin = -(self.C - A) / A * float(w_0 @ self.e)
        return rotation(h / size, size / A * t) @ R_0 @ rotation(self.e, spin * t)


@pytest.fixture(scope="module", params=[1.0, 3.0, 5.5], ids=["rod", "ball", "disc"])
def body(request) -> Body:
    return Body(C=request.param, seed=7)


@pytest.fixture(scope="module")
def floated(body) -> FreeFloating:
    return body.floated()


def test_attitude_precesses(body, floated):
    for t, x_WB in zip(T, floated.attitude, strict=True):
        # The chordal distance of two rotations is sqrt(2) times a small angle.
        error = np.linalg.norm(quaternion_rotation(x_WB) - body.attitude(t))
        assert error / np.sqrt(2) < ATTITUDE


def test_base_rate_precesses(body, floated):
    """The rate turns about the axis in the body, at `-spin`."""
    w_0 = body.start.angular_velocity
    rate = (body.C - A) / A * float(w_0 @ body.e)
    for t, w in zip(T, floated.w, strict=True):
        expected = rotation(body.e, rate * t) @ w_0
        # The rate is E R^T h: off by the attitude's error times |h| / min(A, C).
        h = np.linalg.norm(body.I @ w_0)
        assert np.linalg.norm(w - expected) < ATTITUDE * h / min(A, body.C)


def test_S_circles_about_a_cm_that_moves_straight_on(body, floated):
    R_0, start = quaternion_rotation(body.start.attitude), body.start
    v_cm = start.velocity + R_0 @ np.cross(start.angular_velocity, body.com)
    for t, r_S in zip(T, floated.r_S, strict=True):
        expected = R_0 @ body.com + v_cm * t - body.attitude(t) @ body.com
        # Off by the attitude's error times the arm.
        assert np.linalg.norm(r_S - expected) < ATTITUDE * np.linalg.norm(body.com)


def test_momentum_is_that_of_the_start(body, floated):
    h = quaternion_rotation(body.start.attitude) @ body.I @ body.start.angular_velocity
    # A few float64 products.
    np.testing.assert_allclose(floated.h_cm, h, rtol=0, atol=1e-13)


def test_held_wheel_makes_a_gyrostat():
    """A ball with a held wheel: `h = A w + h_rw`, so `w` turns about `h_rw` in `B`."""
    body, axis, spin = Body(C=A, seed=3), np.array([0.0, 0.6, 0.8]), 150.0
    robot = body.robot(wheels=(Wheel("rw", axis, 0.05),))
    start = body.start._replace(wheel_speed=np.array([spin]))
    floated = free_floating(robot, NoJoints(), T, start, TOLERANCE)
    # w_dot = -w x h / A = -w x h_rw / A.
    rate = 0.05 * spin / A
    h = A * np.linalg.norm(start.angular_velocity) + 0.05 * spin
    for t, w in zip(T, floated.w, strict=True):
        expected = rotation(axis, rate * t) @ start.angular_velocity
        assert np.linalg.norm(w - expected) < ATTITUDE * h / A
    np.testing.assert_array_equal(floated.qd_rw, spin)


def test_free_wheel_on_the_axis_takes_its_inertia_out_of_it():
    """A free wheel keeps `qd_rw + e.w`: the body precesses as if it were not there."""
    body, I_rw = Body(C=5.5, seed=4), 0.5
    without = Body(C=5.0, seed=4)
    w_e = body.start.angular_velocity @ body.e
    # At absolute rest about the axis the wheel has no momentum of its own.
    start = body.start._replace(wheel_speed=np.array([-w_e]))
    robot = body.robot(wheels=(Wheel("rw", body.e, I_rw, "free"),))
    floated = free_floating(robot, NoJoints(), T, start, TOLERANCE)
    for t, x_WB in zip(T, floated.attitude, strict=True):
        error = np.linalg.norm(quaternion_rotation(x_WB) - without.attitude(t))
        assert error / np.sqrt(2) < ATTITUDE
