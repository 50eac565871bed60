"""The points of a robot that have to stay on a table.

They are S, the joints' origins, and the tips of the last links, each as far behind its
link's CM as the CM is from its joint: a robot file says no more of where a link ends.
"""

import numpy as np
from jaxtyping import Float

from orbident.environment.motion import heavy_bodies
from orbident.excitation.floating import Gradient
from orbident.model.kinematics import Poses, carrying_joints, poses
from orbident.model.rotations import rotate, rotate_back
from orbident.robot.description import Robot

BodyPoint = tuple[int, Float[np.ndarray, "3"]]
"""A body's index, and a point in its frame, m."""


def table_points(robot: Robot) -> list[BodyPoint]:
    """The points that have to stay on the table, S first."""
    origins = [(i, np.zeros(3)) for i in range(len(robot.bodies))]
    parents = {joint.parent for joint in robot.joints}
    tips = [(i, 2 * com) for i, _, com in heavy_bodies(robot) if i not in parents]
    return [*origins, *tips]


def points_on_table(
    robot: Robot,
    q: Float[np.ndarray, "n joints"],
    R: Float[np.ndarray, "n 3 3"],
    r_S: Float[np.ndarray, "n 3"],
) -> Float[np.ndarray, "n points 2"]:
    """Where the points are along a motion, x and y in inertial axes, m."""
    at = poses(robot, q)
    arms = [at.arm(*point) for point in table_points(robot)]
    return np.stack([(r_S + rotate(R, arm))[:, :2] for arm in arms], axis=1)


def add_points(f: Gradient, by: Float[np.ndarray, "n points 2"]) -> None:
    """Adds the gradient, from that with respect to where the points are."""
    robot = f.motion.craft.robot
    at = poses(robot, f.motion.q)
    for k, point in enumerate(table_points(robot)):
        add_point(f, at, point, np.pad(by[:, k], ((0, 0), (0, 1))))


def add_point(
    f: Gradient, at: Poses, point: BodyPoint, by: Float[np.ndarray, "n 3"]
) -> None:
    """Adds the gradient, from that with respect to where a point is from the CM.

    Args:
        f: gradient of a scalar with respect to a motion.
        at: of the same motion.
        point: of the robot.
        by: the gradient, inertial axes.
    """
    motion, (body, p) = f.motion, point
    arm = at.arm(body, p)
    f.R += by[:, :, None] * (arm - motion.r_cm)[:, None]
    by_arm = rotate_back(motion.R, by)
    f.r_cm -= by_arm
    moved = at.field_u + np.cross(at.field_w, arm[:, None])
    by_q = np.einsum("nki,ni->nk", moved, by_arm)
    f.q += carrying_joints(motion.craft.robot, body) * by_q
