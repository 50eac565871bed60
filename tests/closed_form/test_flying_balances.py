"""Balances of momentum and energy with forces applied, and motions in closed form."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from flying_robots import moving_start, random_thrusters, waving
from obvious_momentum import quaternion_rotation
from random_robots import DUAL_ARM, random_robot, random_wheels

from orbident.model.equations_of_motion import equations_of_motion
from orbident.robot.description import Robot, Thruster, Wheel
from orbident.robot.parameters import from_mass_com_inertia
from orbident.simulation.flight import FlyingState, FreeFlying, Hold, OpenLoop, standing
from orbident.simulation.free_floating import BaseState
from orbident.simulation.free_flying import free_flying
from orbident.simulation.outside import Pulse

ON, OFF, END = 0.6, 1.3, 2.0
ROBOT = replace(
    random_robot(3, DUAL_ARM, (4,), random_wheels(1, ("free",) * 3)),
    thrusters=random_thrusters(1, ("t1", "t2")),
    feature_point=np.array([0.1, 0.2, -0.3]),
)
PULSES = (Pulse("t1", ON, OFF, 3.0), Pulse("t2", ON, OFF, 2.0))
Z = np.array([0.0, 0.0, 1.0])

# The tolerance of the motion is 1e-11, of rates of the order of 1, and the mass is some
# tens of kilograms; 24 Gauss nodes on 0.7 s of slow sines are exact.
BALANCE = 1e-10


def fly(t: np.ndarray) -> FreeFlying:
    """Thrusters, wheels and joints all at work on a tumbling dual arm."""
    return free_flying(
        ROBOT,
        t,
        moving_start(8, ROBOT),
        Hold(np.zeros(6)),
        waving(2, 6),
        wheels=waving(3, 3),
        pulses=PULSES,
        tolerance=1e-11,
    )


class Flown(NamedTuple):
    """A run, and the weights of its samples in an integral over all of it."""

    run: FreeFlying
    weights: np.ndarray

    def integral(self, values: np.ndarray) -> np.ndarray:
        return self.weights @ values

    def in_inertial_axes(self, vectors: np.ndarray) -> np.ndarray:
        R = [quaternion_rotation(x) for x in self.run.attitude]
        return np.einsum("nij,nj->ni", R, vectors)


@pytest.fixture(scope="module")
def flown() -> Flown:
    """The flight at its start, at the Gauss nodes between the edges, and at its end."""
    nodes, weights = np.polynomial.legendre.leggauss(24)
    t, w = [0.0], [0.0]
    for first, last in ((0.0, ON), (ON, OFF), (OFF, END)):
        t = [*t, *(first + (last - first) / 2 * (nodes + 1))]
        w = [*w, *((last - first) / 2 * weights)]
    return Flown(fly(np.array([*t, END])), np.array([*w, 0.0]))


def test_linear_momentum_is_the_impulse_of_the_thrusters(flown):
    run = flown.run
    impulse = flown.integral(flown.in_inertial_axes(run.force))
    assert np.linalg.norm(impulse) > 1.0
    gained = ROBOT.mass * (run.v_cm[-1] - run.v_cm[0])
    np.testing.assert_allclose(gained, impulse, atol=BALANCE)


def test_angular_momentum_is_the_impulse_of_their_moment(flown):
    run = flown.run
    force = flown.in_inertial_axes(run.force)
    moment = flown.in_inertial_axes(run.torque) + np.cross(run.r_S - run.r_cm, force)
    impulse = flown.integral(moment)
    assert np.linalg.norm(impulse) > 1.0
    gained = run.h_cm[-1] - run.h_cm[0]
    np.testing.assert_allclose(gained, impulse, atol=BALANCE)


def test_energy_is_the_work_of_everything(flown):
    run = flown.run
    power = (
        (flown.in_inertial_axes(run.force) * run.v_S).sum(axis=1)
        + (run.torque * run.w).sum(axis=1)
        + (run.tau * run.qd).sum(axis=1)
        + (run.tau_rw * run.qd_rw).sum(axis=1)
    )
    work = flown.integral(power)
    assert abs(work) > 1.0
    gained = energy(run, -1) - energy(run, 0)
    # Of the whole: wheels at 200 rad/s hold thousands of joules.
    assert abs(gained - work) < BALANCE * energy(run, -1)


def energy(run: FreeFlying, k: int) -> float:
    """`1/2 v H+ v`."""
    R_WB = quaternion_rotation(run.attitude[k])
    v = np.concatenate([R_WB.T @ run.v_cm[k], run.w[k], run.qd[k], run.qd_rw[k]])
    H = equations_of_motion(ROBOT, run.q[[k]], v[None]).H[0]
    return float(0.5 * v @ H @ v)


def test_accelerations_are_derivatives_of_the_velocities():
    """S is off the CM; thrusters, wheels and joints are at work."""
    h = 5e-3
    run = fly(np.array([0.0, *(0.8 + h * np.arange(-3, 4)), END]))
    weights = np.array([-1, 9, -45, 0, 45, -9, 1]) / (60 * h)
    R_WB = quaternion_rotation(run.attitude[4])
    for ours, history in (
        (R_WB @ run.f_S[4], run.v_S),
        (run.v_S[4], run.r_S),
        (run.w_dot[4], run.w),
        (run.qdd[4], run.qd),
        (run.qdd_rw[4], run.qd_rw),
        (run.qd_rw[4], run.q_rw),
    ):
        # Rounding over h, of 200 rad/s; the formula is off by h^6.
        np.testing.assert_allclose(ours, weights @ history[1:-1], atol=1e-9)


MASS = 8.0
COM = np.array([0.2, -0.1, 0.3])
I = np.diag([1.0, 1.5, 2.0])


def body(wheels=(), thrusters=()) -> Robot:
    return Robot(
        name="body",
        motion="spatial",
        bodies=("body",),
        joints=(),
        theta=from_mass_com_inertia(MASS, COM, I)[None],
        feature_point=np.zeros(3),
        wheels=wheels,
        thrusters=thrusters,
    )


def at_rest(wheels: int) -> FlyingState:
    level, zero = np.array([0.0, 0.0, 0.0, 1.0]), np.zeros(3)
    return standing(BaseState(zero, level, zero, np.zeros(wheels)), np.zeros(0))


def steady(*torque: float) -> OpenLoop:
    """Constant torques."""
    return OpenLoop(lambda t: np.tile(torque, (t.size, 1)))


NOTHING = steady()


def test_a_pulse_through_the_cm_moves_the_body_straight():
    """`v = F (off - on) / m`, `r = v (t - middle)`; edges between the samples."""
    robot = body(thrusters=(Thruster("t", COM, np.array([0.6, 0.0, 0.8])),))
    t = np.array([0.0, 1.0, 2.0])
    pulse = Pulse("t", 0.3, 0.7123, 5.0)
    start, command = at_rest(0), Hold(np.zeros(0))
    run = free_flying(robot, t, start, command, NOTHING, pulses=[pulse])
    v = 5.0 * (0.7123 - 0.3) / MASS * np.array([0.6, 0.0, 0.8])
    # RK4 integrates constants exactly; some tens of additions.
    np.testing.assert_allclose(run.v_S, [0 * v, v, v], atol=1e-14)
    middle = (0.3 + 0.7123) / 2
    np.testing.assert_allclose(run.r_S[1:], np.outer(t[1:] - middle, v), atol=1e-14)
    np.testing.assert_allclose(run.attitude, [start.base.attitude] * 3, atol=1e-14)


def test_a_wheel_turns_the_body_the_other_way():
    """About a principal axis: `tau_rw = I_rw (qdd_rw + w_dot)` (Eq. 12)."""
    robot = body(wheels=(Wheel("rw", Z, 0.05, "free"),))
    t = np.linspace(0.0, 2.0, 5)
    start, command = at_rest(1), Hold(np.zeros(0))
    run = free_flying(robot, t, start, command, NOTHING, steady(0.01))
    # No momentum in all: 0 = I w_dot + I_rw qdd_rw.
    qdd_rw = 0.01 / 0.05 / (1 - 0.05 / 2.0)
    w_dot = -0.05 / 2.0 * qdd_rw
    # RK4 integrates constants exactly; some tens of additions.
    np.testing.assert_allclose(run.qd_rw[:, 0], qdd_rw * t, atol=1e-13)
    np.testing.assert_allclose(run.q_rw[:, 0], qdd_rw * t**2 / 2, atol=1e-13)
    np.testing.assert_allclose(run.w, np.outer(w_dot * t, Z), atol=1e-13)
    np.testing.assert_allclose(run.tau_rw, 0.01, rtol=1e-13)
    np.testing.assert_allclose(run.h_cm, 0.0, atol=1e-14)
