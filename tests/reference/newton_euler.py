"""Newton and Euler for every body by itself, in plain NumPy: what a motion takes.

    f = m a + alpha x s + w x (w x s)          force on a body, s = m c
    n = s x a + J alpha + w x J w              moment about its origin

A generalised force is the power of all of these at a unit speed.
"""

from typing import NamedTuple

import numpy as np
from obvious_momentum import body_motion

from orbident.robot.description import Robot


class Accelerated(NamedTuple):
    """A body's motion as the feature point S sees it, inertial, base axes."""

    R: np.ndarray
    d: np.ndarray
    w: np.ndarray
    alpha: np.ndarray
    a: np.ndarray
    """Acceleration of the body's origin."""


def inertia_of(theta_i: np.ndarray, R: np.ndarray) -> tuple:
    """Mass, first moment and inertia about the body's origin, base axes."""
    m, mx, my, mz, xx, xy, yy, xz, yz, zz = theta_i
    J = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return m, R @ np.array([mx, my, mz]), R @ J @ R.T


def accelerated(robot: Robot, body: int, q, qd, qdd, w, alpha) -> Accelerated:
    """The parent's acceleration, carried over the joint."""
    if body == 0:
        return Accelerated(np.eye(3), np.zeros(3), w, alpha, np.zeros(3))
    k = body - 1
    joint = robot.joints[k]
    parent = accelerated(robot, joint.parent, q, qd, qdd, w, alpha)
    at = body_motion(robot, body, q, qd, w)
    axis = parent.R @ joint.R_PJ @ joint.axis
    r, W = at.d - parent.d, parent.w
    a = parent.a + np.cross(parent.alpha, r) + np.cross(W, np.cross(W, r))
    if joint.kind == "revolute":
        alpha = parent.alpha + axis * qdd[k] + np.cross(W, axis) * qd[k]
    else:
        alpha = parent.alpha
        a = a + 2 * np.cross(W, axis) * qd[k] + axis * qdd[k]
    return Accelerated(at.R, at.d, at.w, alpha, a)


class Taken(NamedTuple):
    """What a motion takes, and how S accelerates; base axes."""

    Q: np.ndarray
    a_S: np.ndarray


def inverse_dynamics(robot: Robot, q, v, vd, units=None) -> Taken:
    """`Q` over `[v_cm, w, qd, qd_rw]`; `units` are the `unit_motions` at `q`."""
    units = units or unit_motions(robot, q)
    joints = len(robot.joints)
    v_cm, w, qd, qd_rw = np.split(v, [3, 6, 6 + joints])
    v_cm_dot, alpha, qdd, qdd_rw = np.split(vd, [3, 6, 6 + joints])
    bodies = range(len(robot.bodies))
    moving = [accelerated(robot, i, q, qd, qdd, w, alpha) for i in bodies]
    parts = [inertia_of(robot.theta[i], moving[i].R) for i in bodies]

    def force(i: int, a_S: np.ndarray) -> np.ndarray:
        (m, s, _), at = parts[i], moving[i]
        turning = np.cross(at.alpha, s) + np.cross(at.w, np.cross(at.w, s))
        return m * (at.a + a_S) + turning

    # Base axes turn: the CM's acceleration is the derivative in them, and w x v_cm.
    M = sum(m for m, _, _ in parts)
    relative = sum(force(i, np.zeros(3)) for i in bodies) / M
    a_S = v_cm_dot + np.cross(w, v_cm) - relative

    h_rw, h_rw_dot = np.zeros((2, 3))
    for wheel, speed, rate in zip(robot.wheels, qd_rw, qdd_rw, strict=True):
        h_rw = h_rw + wheel.axis * wheel.inertia * speed
        h_rw_dot = h_rw_dot + wheel.axis * wheel.inertia * rate
    loads = []
    for i in bodies:
        (_, s, J), at = parts[i], moving[i]
        n = np.cross(s, at.a + a_S) + J @ at.alpha + np.cross(at.w, J @ at.w)
        if i == 0:
            n = n + h_rw_dot + np.cross(w, h_rw)
        loads.append((force(i, a_S), n))

    Q = np.array([power(unit, loads) for unit in units])
    for k, wheel in enumerate(robot.wheels):
        Q[6 + joints + k] = wheel.inertia * (wheel.axis @ alpha + qdd_rw[k])
    return Taken(Q, a_S)


def velocities(robot: Robot, q, v) -> list[tuple[np.ndarray, np.ndarray]]:
    """Velocity of each body's origin, and its angular velocity."""
    v_cm, w, qd = v[:3], v[3:6], v[6 : 6 + len(robot.joints)]
    bodies = range(len(robot.bodies))
    at = [body_motion(robot, i, q, qd, w) for i in bodies]
    parts = [inertia_of(robot.theta[i], at[i].R) for i in bodies]
    P = sum(m * b.v + np.cross(b.w, s) for (m, s, _), b in zip(parts, at, strict=True))
    v_S = v_cm - P / sum(m for m, _, _ in parts)
    return [(v_S + b.v, b.w) for b in at]


def unit_motions(robot: Robot, q) -> list[list[tuple[np.ndarray, np.ndarray]]]:
    """The velocities of all bodies, for each generalised speed alone."""
    speeds = 6 + len(robot.joints) + len(robot.wheels)
    return [velocities(robot, q, unit) for unit in np.eye(speeds)]


def power(moving, loads) -> float:
    """The power of a force at each body's origin and a moment."""
    pairs = zip(loads, moving, strict=True)
    return float(sum(f @ u + n @ w for (f, n), (u, w) in pairs))


def wrench_force(robot: Robot, q, body: int, point, F, n) -> np.ndarray:
    """`J^T (F, n)` of a wrench at a point of a body, its frame."""
    R = body_motion(robot, body, q, np.zeros(len(robot.joints)), np.zeros(3)).R
    loads = [(np.zeros(3), np.zeros(3)) for _ in robot.bodies]
    loads[body] = (F, n + np.cross(R @ point, F))
    return np.array([power(unit, loads) for unit in unit_motions(robot, q)])


def forward_dynamics(robot: Robot, q, v, Q, vd, free) -> Taken:
    """`v'` where some of it is known (`free` is 0); `Q` is linear in `v'`."""
    units = unit_motions(robot, q)
    known = np.where(free == 1, 0.0, vd)
    start = inverse_dynamics(robot, q, v, known, units).Q
    chosen = np.flatnonzero(free)
    columns = []
    for k in chosen:
        unit = known.copy()
        unit[k] += 1.0
        columns.append((inverse_dynamics(robot, q, v, unit, units).Q - start)[chosen])
    found = known.copy()
    if chosen.size:
        found[chosen] = np.linalg.solve(np.transpose(columns), (Q - start)[chosen])
    return Taken(found, inverse_dynamics(robot, q, v, found, units).a_S)
