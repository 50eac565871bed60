"""Kinematics and momentum as a textbook has them: recursive, body by body, in numpy.

Shares no code with the package: what it says of a robot is the reference for the
vectorised functions.
"""

from typing import NamedTuple

import numpy as np

from orbident.robot.description import Joint, Robot

Vector = np.ndarray


class Body(NamedTuple):
    """A body's motion as the feature point S sees it, base axes."""

    R: np.ndarray
    d: Vector
    w: Vector
    v: Vector


class Motion(NamedTuple):
    """Totals of the system, base axes."""

    first_moment: Vector
    linear: Vector
    """Linear momentum relative to S."""
    angular: Vector
    """Angular momentum about S."""
    h_rs: Vector
    """Angular momentum about the system CM."""


def rotation(axis: Vector, angle: float) -> np.ndarray:
    """The rotation matrix, by turning each unit vector about the axis."""
    c, s = np.cos(angle), np.sin(angle)
    columns = [
        c * e + s * np.cross(axis, e) + (1 - c) * axis * (axis @ e) for e in np.eye(3)
    ]
    return np.array(columns).T


def quaternion_rotation(x: Vector) -> np.ndarray:
    """`R_WB` of a scalar-last quaternion, from its axis and angle."""
    sine = float(np.linalg.norm(x[:3]))
    axis = x[:3] / sine if sine > 0 else np.array([1.0, 0.0, 0.0])
    return rotation(axis, 2 * float(np.arctan2(sine, x[3])))


def body_motion(robot: Robot, body: int, q: Vector, qd: Vector, w: Vector) -> Body:
    """The parent's motion, carried over the joint."""
    if body == 0:
        return Body(np.eye(3), np.zeros(3), w, np.zeros(3))
    k = body - 1
    joint = robot.joints[k]
    parent = body_motion(robot, joint.parent, q, qd, w)
    return _child(parent, joint, q[k], qd[k])


def _child(parent: Body, joint: Joint, q: float, qd: float) -> Body:
    R_joint = parent.R @ joint.R_PJ
    axis = R_joint @ joint.axis
    if joint.kind == "revolute":
        arm = parent.R @ joint.p_PJ
        R, turning, sliding = R_joint @ rotation(joint.axis, q), axis * qd, 0 * axis
    else:
        arm = parent.R @ joint.p_PJ + axis * q
        R, turning, sliding = R_joint, 0 * axis, axis * qd
    v = parent.v + np.cross(parent.w, arm) + sliding
    return Body(R, parent.d + arm, parent.w + turning, v)


def system_motion(robot: Robot, q: Vector, qd: Vector, w: Vector) -> Motion:
    """Momentum, from each body's CM and its inertia about its own origin."""
    first, linear, angular = np.zeros((3, 3))
    for i, (m, mx, my, mz, xx, xy, yy, xz, yz, zz) in enumerate(robot.theta):
        body = body_motion(robot, i, q, qd, w)
        s = body.R @ np.array([mx, my, mz])
        I = body.R @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ body.R.T
        p = m * body.v + np.cross(body.w, s)
        first += m * body.d + s
        linear += p
        angular += np.cross(body.d, p) + np.cross(s, body.v) + I @ body.w
    h_rs = angular - np.cross(first, linear) / robot.mass
    return Motion(first, linear, angular, h_rs)
