"""A floating robot that is pushed: the momentum changes while the joints move on.

    h_cm' = n_cm,   M v_cm' = f,   D w + D_q qd + A_rw qd_rw = R_WB^T h_cm,

by RK4 steps, with the joints and the wheels as functions of time.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from recordings import Clean

from orbident.model.core_robot import wheels_of
from orbident.model.kinematics import inertia
from orbident.model.rotations import quaternion_matrix, quaternion_rate
from orbident.simulation.measure import Truth

STEP = 0.05
"""s, at most; 1e-8 rad of error where base and joints turn at a radian a second."""


class Now(NamedTuple):
    """The robot at one time."""

    t: float
    inside: float
    """The middle of the step: thrusters go on and off between steps."""
    R_WB: np.ndarray
    w: np.ndarray
    """Base axes, rad/s."""
    v_S: np.ndarray
    """Inertial axes, m/s."""
    to_cm: np.ndarray
    """Vector from S to the system CM, base axes, m."""
    r_cm: np.ndarray
    """Place of the system CM, from S at the start, inertial axes, m."""
    mass: float


class Wrench(NamedTuple):
    """On the robot, base axes."""

    force: np.ndarray
    """N."""
    torque: np.ndarray
    """About the system CM, N m."""


class Terms(NamedTuple):
    """What depends on time alone, at one time."""

    t: float
    D: np.ndarray
    h_moving: np.ndarray
    """`D_q qd + A_rw qd_rw`."""
    to_cm: np.ndarray
    v_arm: np.ndarray
    """`J_cm qd`."""


Push = Callable[[Now], Wrench]
Spin = Callable[[np.ndarray], np.ndarray]
"""A function from times to the factors of all wheels' first speeds."""

NOTHING = np.zeros(3)


def constant(t: np.ndarray) -> np.ndarray:
    return np.ones_like(t)


def pushed(clean: Clean, push: Push, spin: Spin = constant) -> Truth:
    """The motion under a wrench; `spin` is what the wheels do."""
    t = clean.t
    parts = int(np.ceil(np.diff(t).max() / STEP))
    grid = np.linspace(t[:-1], t[1:], 2 * parts, endpoint=False, axis=1).ravel()
    times = np.append(grid, t[-1])
    terms = _terms(clean, times, spin)
    x = _first_state(clean, terms[0])
    shown = [_shown(clean, terms[0], x, push)]
    for k in range(0, times.size - 1, 2):
        x = _stepped(clean, terms[k : k + 3], x, push)
        if (k + 2) % (2 * parts) == 0:
            shown.append(_shown(clean, terms[k + 2], x, push))
    attitude, w, position, velocity = map(np.array, zip(*shown, strict=True))
    angle = _integral(times, spin(times))[:: 2 * parts]
    return clean.true._replace(
        q_rw=np.outer(angle, clean.start.wheel_speed),
        qd_rw=np.outer(spin(t), clean.start.wheel_speed),
        gyro=w,
        attitude=attitude,
        position=position - position[0],
        velocity=velocity,
    )


def _terms(clean: Clean, times: np.ndarray, spin: Spin) -> list[Terms]:
    robot = clean.robot
    q, qd, _ = clean.joints.at(times)
    at = inertia(robot, q)
    h_rw = np.outer(spin(times), wheels_of(robot).A_rw @ clean.start.wheel_speed)
    h_moving = np.einsum("nij,nj->ni", at.D_q, qd) + h_rw
    v_arm = np.einsum("nij,nj->ni", at.J_cm, qd)
    return [
        Terms(*each) for each in zip(times, at.D, h_moving, at.r_cm, v_arm, strict=True)
    ]


def _first_state(clean: Clean, at: Terms) -> np.ndarray:
    """`[x_WB, h_cm, r_cm, v_cm]`, inertial axes."""
    R_WB = quaternion_matrix(clean.start.attitude)
    w = clean.start.angular_velocity
    h_cm = R_WB @ (at.D @ w + at.h_moving)
    v_cm = clean.start.velocity + R_WB @ (np.cross(w, at.to_cm) + at.v_arm)
    return np.concatenate([clean.start.attitude, h_cm, R_WB @ at.to_cm, v_cm])


def _rate(
    clean: Clean, at: Terms, inside: float, x: np.ndarray, push: Push
) -> tuple[np.ndarray, Now]:
    x_WB, h_cm, r_cm, v_cm = np.split(x, [4, 7, 10])
    R_WB = quaternion_matrix(x_WB / np.linalg.norm(x_WB))
    balance = R_WB.T @ h_cm - at.h_moving
    if clean.space:
        w = np.linalg.solve(at.D, balance)
    else:
        w = np.array([0.0, 0.0, balance[2] / at.D[2, 2]])
    v_S = v_cm - R_WB @ (np.cross(w, at.to_cm) + at.v_arm)
    now = Now(at.t, inside, R_WB, w, v_S, at.to_cm, r_cm, clean.robot.mass)
    force, torque = push(now)
    if not clean.space:
        force, torque = force * [1, 1, 0], torque * [0, 0, 1]
    turning = quaternion_rate(x_WB, w)
    return (
        np.concatenate([turning, R_WB @ torque, v_cm, R_WB @ force / now.mass]),
        now,
    )


def _stepped(clean: Clean, at: list[Terms], x: np.ndarray, push: Push) -> np.ndarray:
    """RK4 from the first to the last of three times."""
    start, middle, end = at
    h = end.t - start.t
    a, _ = _rate(clean, start, middle.t, x, push)
    b, _ = _rate(clean, middle, middle.t, x + h / 2 * a, push)
    c, _ = _rate(clean, middle, middle.t, x + h / 2 * b, push)
    d, _ = _rate(clean, end, middle.t, x + h * c, push)
    return x + h / 6 * (a + 2 * b + 2 * c + d)


def _shown(
    clean: Clean, at: Terms, x: np.ndarray, push: Push
) -> tuple[np.ndarray, ...]:
    """Attitude, base rate, position and velocity of S."""
    _, now = _rate(clean, at, at.t, x, push)
    return (
        x[:4] / np.linalg.norm(x[:4]),
        now.w,
        x[7:10] - now.R_WB @ now.to_cm,
        now.v_S,
    )


def _integral(t: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """Trapezoidal: exact where the rate changes evenly."""
    steps = np.diff(t) * (rate[1:] + rate[:-1]) / 2
    return np.concatenate([[0.0], np.cumsum(steps)])
