"""Eqs. 3 to 14 as one reads them, in NumPy, one state at a time.

Slow and obvious: the oracle of the numerical core. Positions may be complex, so that a
derivative is the imaginary part of a complex step, exact to rounding.
"""

from typing import NamedTuple

import numpy as np

from orbident.robot.description import Robot

Array = np.ndarray


def cross_matrix(v: Array) -> Array:
    x, y, z = v
    return np.array([[0 * x, -z, y], [z, 0 * x, -x], [-y, x, 0 * x]])


def rotation(axis: Array, angle: complex) -> Array:
    """Rodrigues."""
    S = cross_matrix(axis)
    return np.eye(3) + np.sin(angle) * S + (1 - np.cos(angle)) * (S @ S)


class Body(NamedTuple):
    """A body's pose, and the motion that each joint's unit rate gives it, base axes."""

    R: Array
    d: Array
    w: Array
    """3 x joints."""
    v: Array
    """Velocity of its origin relative to S, 3 x joints."""


def bodies(robot: Robot, q: Array) -> list[Body]:
    """All bodies, from the base to the tips."""
    none = np.zeros((3, len(robot.joints)), dtype=q.dtype)
    found = [Body(np.eye(3), np.zeros(3), none, none)]
    for k, joint in enumerate(robot.joints):
        parent = found[joint.parent]
        axis = parent.R @ joint.R_PJ @ joint.axis
        arm, R = parent.R @ joint.p_PJ, parent.R @ joint.R_PJ
        own = np.eye(len(robot.joints))[k]
        turns = joint.kind == "revolute"
        if turns:
            R = R @ rotation(joint.axis, q[k])
        else:
            arm = arm + q[k] * axis
        w = parent.w + np.outer(axis, own) * turns
        v = parent.v - cross_matrix(arm) @ parent.w + np.outer(axis, own) * (not turns)
        found.append(Body(R, parent.d + arm, w, v))
    return found


class System(NamedTuple):
    """Mass, CM and inertia about it, over the base rate and the joint rates."""

    M: float
    r_cm: Array
    J_cm: Array
    D: Array
    D_q: Array
    D_qq: Array


def system(robot: Robot, q: Array) -> System:
    """Sums over the bodies, each with its velocity relative to the system CM."""
    placed, K = bodies(robot, q), len(robot.joints)
    M = robot.theta[:, 0].sum()
    # The first moment, and its change with [w, qd].
    s = sum(t[0] * b.d + b.R @ t[1:4] for b, t in zip(placed, robot.theta, strict=True))
    r_cm = s / M
    twists = []
    for b in placed:
        w = np.hstack([np.eye(3), b.w])
        v = np.hstack([-cross_matrix(b.d), b.v])
        twists.append((w, v))
    P = np.zeros((3, 3 + K), dtype=q.dtype)
    for b, t, (w, v) in zip(placed, robot.theta, twists, strict=True):
        P = P + t[0] * v - cross_matrix(b.R @ t[1:4]) @ w
    H = np.zeros((3 + K, 3 + K), dtype=q.dtype)
    for b, t, (w, v) in zip(placed, robot.theta, twists, strict=True):
        xx, xy, yy, xz, yz, zz = t[4:]
        I = b.R @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ b.R.T
        s_x, u = cross_matrix(b.R @ t[1:4]), v - P / M
        H = H + t[0] * u.T @ u + w.T @ I @ w
        H = H + w.T @ s_x @ u - u.T @ s_x @ w
    return System(M, r_cm, P[:, 3:] / M, H[:3, :3], H[:3, 3:], H[3:, 3:])


def H_plus(robot: Robot, q: Array) -> Array:
    """Eq. 14."""
    at, K, N = system(robot, q), len(robot.joints), len(robot.wheels)
    H = np.zeros((6 + K + N, 6 + K + N), dtype=q.dtype)
    H[:3, :3] = at.M * np.eye(3)
    H[3:6, 3:6], H[3:6, 6 : 6 + K], H[6 : 6 + K, 3:6] = at.D, at.D_q, at.D_q.T
    H[6 : 6 + K, 6 : 6 + K] = at.D_qq
    for k, wheel in enumerate(robot.wheels):
        H[3:6, 6 + K + k] = H[6 + K + k, 3:6] = wheel.inertia * wheel.axis
        H[6 + K + k, 6 + K + k] = wheel.inertia
    return H


STEP = 1e-30
"""Size of complex steps: its square is lost in rounding."""


def lagrange(robot: Robot, q: Array, v: Array, vd: Array) -> Array:
    """The left-hand sides of Eqs. 9 to 12 along `q' = qd`, `v' = vd`."""
    K = len(robot.joints)
    qd, v_cm, w = v[6 : 6 + K], v[:3], v[3:6]
    p = H_plus(robot, q) @ v
    p_dot = (H_plus(robot, q + 1j * STEP * qd) @ (v + 1j * STEP * vd)).imag / STEP
    steps = q + 1j * STEP * np.eye(K)
    by_q = [(0.5 * v @ H_plus(robot, x) @ v).imag / STEP for x in steps]
    forces = p_dot.copy()
    forces[:3] += np.cross(w, p[:3])
    forces[3:6] += np.cross(w, p[3:6]) + np.cross(v_cm, p[:3])
    forces[6 : 6 + K] -= np.array(by_q).reshape(K)
    return forces
