"""Where the bodies are, and how they move; base axes, seen from the feature point S."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident import _core
from orbident.model.core_robot import core_tree
from orbident.robot.description import Robot
from orbident.robot.parameters import cross_matrix
from orbident.threads import processors


class Poses(NamedTuple):
    """Where every body is, and the motion that a unit rate of each joint causes.

    That motion is the same rigid field for all bodies that the joint carries: its
    angular velocity, and its velocity at S.
    """

    R: Float[np.ndarray, "n bodies 3 3"]
    """`R_Bi`."""
    d: Float[np.ndarray, "n bodies 3"]
    """`p_SBi`, m."""
    field_w: Float[np.ndarray, "n joints 3"]
    field_u: Float[np.ndarray, "n joints 3"]


def poses(robot: Robot, q: Float[np.ndarray, "n joints"]) -> Poses:
    """Forward kinematics at the joint positions `q` (rad or m)."""
    return Poses(*_core.poses(core_tree(robot), np.ascontiguousarray(q), processors()))


def point_jacobian(
    robot: Robot,
    q: Float[np.ndarray, " joints"],
    body: int,
    p: Float[np.ndarray, "3"],
) -> Float[np.ndarray, "6 3+joints"]:
    """Velocity of a body-fixed point relative to S, over `[w, qd]`.

    Args:
        robot: its geometry.
        q: joint positions, rad or m.
        body: index of the body.
        p: the point in the body's frame, m.

    Returns:
        Rows: linear velocity relative to S, then angular velocity, base axes.
    """
    at = poses(robot, q[None])
    r = at.d[0, body] + at.R[0, body] @ p
    carries = carrying_joints(robot, body)[:, None]
    linear = carries * (at.field_u[0] + np.cross(at.field_w[0], r))
    angular = carries * at.field_w[0]
    return np.block([[-cross_matrix(r), linear.T], [np.eye(3), angular.T]])


def carrying_joints(robot: Robot, body: int) -> Float[np.ndarray, " joints"]:
    """1 for each joint that moves the body: the body is at or beyond it."""
    carries = np.zeros(len(robot.joints))
    while body > 0:
        carries[body - 1] = 1.0
        body = robot.joints[body - 1].parent
    return carries
