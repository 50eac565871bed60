"""The points of a robot that have to stay on a table.

They are S, the joints' origins, and the tips of the last links, each as far behind its
link's CM as the CM is from its joint: a robot file says no more of where a link ends.

A table may be a rectangle along inertial axes, or round. Where on it the robot begins
is free: what a motion uses of a round one is the smallest circle around all points.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.environment.motion import heavy_bodies
from orbident.excitation.criterion import smooth_maximum
from orbident.excitation.floating import Gradient
from orbident.model.kinematics import Poses, carrying_joints, poses
from orbident.model.rotations import rotate, rotate_back
from orbident.robot.description import Robot

BodyPoint = tuple[int, Float[np.ndarray, "3"]]
"""A body's index, and a point in its frame, m."""


TABLE_SIZES = "table width", "table depth", "table radius"
"""Names of the fields of `TableSize` as limits."""


class TableSize(NamedTuple):
    """A table, or what a motion needs of one, m; infinite where nothing limits it."""

    width: float = np.inf
    """Along x, inertial axes."""
    depth: float = np.inf
    """Along y."""
    radius: float = np.inf
    """Of one that is round."""


ANY_TABLE = TableSize()


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


def use_of_table(
    size: str, limit: float, points: Float[np.ndarray, "*n 2"], p: float
) -> tuple[float, Float[np.ndarray, "*n 2"]]:
    """The square of the share of a table that is used, and its gradient.

    The size is one of `TABLE_SIZES`; its limit and the points are in m. A mean of power
    `p` stands for the largest.
    """
    x = points / limit
    if size == TABLE_SIZES[-1]:
        # At the least over all centres its own gradient is zero.
        off = x - centre_of(x.reshape(-1, 2), p)
        most, shares = smooth_maximum(np.sum(off**2, axis=-1), p)
        return most, 2 / limit * shares[..., None] * off
    axis = TABLE_SIZES.index(size)
    most, of_most = smooth_maximum(x[..., axis], p)
    least, of_least = smooth_maximum(-x[..., axis], p)
    by_points = np.zeros_like(x)
    by_points[..., axis] = 2 / limit * (most + least) * (of_most - of_least)
    return (most + least) ** 2, by_points


ROUND = 1e5
"""Power for the centre of a round table: its radius is 0.01 % above the least."""


def size_of_table(points: Float[np.ndarray, "*n 2"]) -> TableSize:
    """The smallest table under points, m."""
    points = points.reshape(-1, 2)
    width, depth = np.ptp(points, axis=0).tolist()
    size = max(width, depth) or 1.0
    off = points / size - centre_of(points / size, ROUND)
    return TableSize(width, depth, size * float(np.linalg.norm(off, axis=1).max()))


SMOOTHER = 4.0
"""A power so many times smaller gives Newton's method its start."""

EXACT = 1e-14
"""Part of the radius' square that no step of Newton's method can gain by rounding."""

STEPS = 20
"""The most of Newton's method for one power; it takes three or four."""


def centre_of(x: Float[np.ndarray, "n 2"], p: float) -> Float[np.ndarray, "2"]:
    """The centre `c` of the smallest circle around points, by Newton's method.

    The mean of power `p` of `|x - c|^2` is convex in `c`, and for the power infinity it
    is the square of the circle's radius.
    """
    c = (x.min(axis=0) + x.max(axis=0)) / 2
    power = min(p, 1 / np.sum((x - c) ** 2, axis=1).max(initial=1 / p))
    while True:
        for _ in range(STEPS):
            off = x - c
            value, shares = smooth_maximum(np.sum(off**2, axis=1), power)
            mean = shares @ off
            spread = (off * shares[:, None]).T @ off - np.outer(mean, mean)
            step = np.linalg.solve(np.eye(2) + 2 * power * spread, mean)
            fall = 2 * float(mean @ step)
            while fall > EXACT * value:
                tried = np.sum((off - step) ** 2, axis=1)
                if smooth_maximum(tried, power)[0] < value:
                    break
                step, fall = step / 2, fall / 2
            c = c + step
            if fall <= EXACT * value:
                break
        if power >= p:
            return c
        power = min(SMOOTHER * power, p)


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

    The gradient `by` is in inertial axes.
    """
    motion, (body, p) = f.motion, point
    arm = at.arm(body, p)
    f.R += by[:, :, None] * (arm - motion.r_cm)[:, None]
    by_arm = rotate_back(motion.R, by)
    f.r_cm -= by_arm
    moved = at.field_u + np.cross(at.field_w, arm[:, None])
    by_q = np.einsum("nki,ni->nk", moved, by_arm)
    f.q += carrying_joints(motion.craft.robot, body) * by_q
