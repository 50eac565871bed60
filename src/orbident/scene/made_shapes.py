"""Shapes for bodies that a URDF does not show: boxes and rods where things are."""

import numpy as np
from jaxtyping import Float

from orbident.robot.description import Robot
from orbident.robot.parameters import FIRST_MOMENT, MASS, inertia_about_com
from orbident.scene.shapes import (
    BASE,
    LINKS,
    Shape,
    box,
    cylinder,
    rod,
    z_towards,
)

THIN = 0.025
"""Radius of a rod, of the robot's size."""
STRAIGHT = 0.01
"""Products of inertia below this part of the largest moment turn no box."""


def robot_size(robot: Robot) -> float:
    """The longest way from S along the joints to a joint or a CM, m."""
    reach = np.zeros(len(robot.bodies))
    for k, joint in enumerate(robot.joints):
        reach[k + 1] = reach[joint.parent] + np.linalg.norm(joint.p_PJ)
    ends = [reach[i] + np.linalg.norm(_com(robot, i)) for i in range(reach.size)]
    base = np.linalg.norm(_even_lengths(robot.theta[0])[0]) / 2
    return float(max(*ends, base)) or 1.0


def made_shapes(robot: Robot, body: int, size: float) -> list[Shape]:
    """A body from what momentum knows of it: joints, CM and inertia.

    The base is the box of even density that has its inertia, with rods to its joints. A
    link is a rod from its joint to each next one; the last one ends as far behind its
    CM as the CM is from its joint.

    Args:
        robot: with its nominal inertia.
        body: index of the body.
        size: of the robot, m.
    """
    com = _com(robot, body)
    joints = [joint.p_PJ for joint in robot.joints if joint.parent == body]
    if body == 0:
        lengths, R = _even_lengths(robot.theta[0])
        base = box(np.maximum(lengths, 0.05 * size), BASE)
        shapes, start, ends, colour = [base.moved(0, R, com)], com, joints, BASE
    else:
        colour = LINKS[(body - 1) % len(LINKS)]
        shapes = [_hub(robot, body, size)]
        start, ends = np.zeros(3), joints or [2 * com]
    shapes += [
        rod(start, end, THIN * size, colour)
        for end in ends
        if np.linalg.norm(end - start) > THIN * size
    ]
    return [shape._replace(frame=body) for shape in shapes]


def _hub(robot: Robot, body: int, size: float) -> Shape:
    """A short cylinder along the joint's axis."""
    hub = cylinder(1.4 * THIN * size, 3 * THIN * size, BASE)
    return hub.moved(0, z_towards(robot.joints[body - 1].axis), np.zeros(3))


def _com(robot: Robot, body: int) -> Float[np.ndarray, "3"]:
    theta_i = robot.theta[body]
    return theta_i[FIRST_MOMENT] / theta_i[MASS] if theta_i[MASS] else np.zeros(3)


def _even_lengths(
    theta_i: Float[np.ndarray, "10"],
) -> tuple[Float[np.ndarray, "3"], Float[np.ndarray, "3 3"]]:
    """Side lengths, m, and axes of the box of even density with this inertia."""
    m = theta_i[MASS]
    if m <= 0:
        return np.zeros(3), np.eye(3)
    I = inertia_about_com(theta_i)
    moments, R = np.diag(I), np.eye(3)
    if np.abs(I - np.diag(moments)).max() > STRAIGHT * np.abs(moments).max():
        moments, R = np.linalg.eigh(I)
    # I_k = m/12 (the other two lengths squared)
    squares = 6 / m * (moments.sum() - 2 * moments)
    return np.sqrt(np.maximum(squares, 0.0)), R
