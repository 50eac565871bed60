"""The system's inertia as ellipsoids, and how large each half axis may be."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.gaussian import NINETY_FIVE
from orbident.model.kinematics import inertia
from orbident.model.minimal_sets import minimal_sets
from orbident.model.rotations import quaternion_matrix, rotate
from orbident.robot.description import Robot
from orbident.scene.replay import MotionHistory


class InertiaEllipsoids(NamedTuple):
    """Ellipsoids of even density, in the inertial frame."""

    R: Float[np.ndarray, "n 3 3"]
    """Their axes, as columns."""
    r_cm: Float[np.ndarray, "n 3"]
    """m."""
    lengths: Float[np.ndarray, "n 3"]
    """Half of their axes, m."""


def inertia_ellipsoids(robot: Robot, motion: MotionHistory) -> InertiaEllipsoids:
    """The ellipsoids with the system's mass, CM and inertia, joints held.

    Moments about their axes are `I_1 = M/5 (a_2^2 + a_3^2)`, and so on; those of the
    system are of `D` (Eq. 3), which is identified while its bodies' inertia is not.
    """
    at, R_WB = inertia(robot, motion.q), quaternion_matrix(motion.x_WB)
    _, R = np.linalg.eigh(at.D)
    # For a rotation: eigenvectors may be left-handed.
    R[..., 0] *= np.linalg.det(R)[:, None]
    squares = _squared_lengths(robot, motion.q, R)
    return InertiaEllipsoids(
        R_WB @ R,
        motion.r_S + rotate(R_WB, at.r_cm),
        np.sqrt(np.maximum(squares, 0.0)),
    )


def _squared_lengths(
    robot: Robot, q: Float[np.ndarray, "n joints"], R: Float[np.ndarray, "n 3 3"]
) -> Float[np.ndarray, "n 3"]:
    """`a_k^2 = 5/(2 M) (tr D - 2 u_k^T D u_k)`, m^2, `u_k` the columns of `R`."""
    moments = np.einsum("nik,nij,njk->nk", R, inertia(robot, q).D, R)
    return 2.5 / robot.mass * (moments.sum(axis=1, keepdims=True) - 2 * moments)


def inertia_intervals(
    robot: Robot, root: Float[np.ndarray, "beta beta"], motion: MotionHistory
) -> tuple[InertiaEllipsoids, InertiaEllipsoids]:
    """Ellipsoids with the lower and the upper 95 % ends of every half axis by itself.

    The interval is that of a half axis' square, whose deviation is of first order in
    the base parameters. CM and directions are held. The covariance of the robot's
    identified base parameters is `root root^T`.
    """
    found = inertia_ellipsoids(robot, motion)
    R = quaternion_matrix(motion.x_WB).mT @ found.R
    variance = np.zeros_like(found.lengths)
    for column in (minimal_sets(robot).base.theta_of @ root).T:
        off = column.reshape(robot.theta.shape)
        above, below = (
            _squared_lengths(replace(robot, theta=theta), motion.q, R)
            for theta in (robot.theta + off, robot.theta - off)
        )
        variance += ((above - below) / 2) ** 2
    half = NINETY_FIVE * np.sqrt(variance)
    low, high = (np.sqrt(np.maximum(found.lengths**2 + x, 0.0)) for x in (-half, half))
    return found._replace(lengths=low), found._replace(lengths=high)
