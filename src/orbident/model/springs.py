"""The springs and dampers of joints that nobody measures."""

import numpy as np
from jaxtyping import Float

from orbident.model.kinematics import poses
from orbident.robot.description import Robot
from orbident.robot.parameters import INERTIA_ENTRIES, PER_BODY


def carried_inertia(robot: Robot, joint: int) -> Float[np.ndarray, " theta"]:
    """By each entry of `theta`, the inertia of what a joint carries, about its axis.

    Its product with `theta` is in kg m^2, or in kg for a joint that slides. Joints
    beyond it are at zero.

    Args:
        robot: of which the geometry counts.
        joint: its index.
    """
    at = poses(robot, np.zeros((1, len(robot.joints))))
    by = np.zeros((len(robot.bodies), PER_BODY))
    a = at.R[0, joint + 1] @ robot.joints[joint].axis
    carries = {joint + 1}
    for k, each in enumerate(robot.joints):
        if each.parent in carries:
            carries.add(k + 1)
    for i in carries:
        if robot.joints[joint].kind == "prismatic":
            by[i, 0] = 1.0
            continue
        R, d = at.R[0, i], at.d[0, i] - at.d[0, joint + 1]
        across, own = np.cross(a, d), R.T @ a
        by[i, 0] = across @ across
        by[i, 1:4] = 2 * np.cross(a, R.T) @ across
        by[i, 4:] = [(1 + (r != c)) * own[r] * own[c] for r, c in INERTIA_ENTRIES]
    return by.ravel()
