"""Where everything is over time: bodies, wheels, the system CM and momentum."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.model.inertia import inertia
from orbident.model.kinematics import poses
from orbident.model.rotations import axis_rotation, quaternion_matrix, rotate
from orbident.model.wheel_arrays import wheels_of
from orbident.robot.description import Robot
from orbident.scene.scene import Scene


class MotionHistory(NamedTuple):
    """What moves, at some times; inertial axes but for `w`."""

    t: Float[np.ndarray, " n"]
    q: Float[np.ndarray, "n joints"]
    qd: Float[np.ndarray, "n joints"]
    x_WB: Float[np.ndarray, "n 4"]
    w: Float[np.ndarray, "n 3"]
    """Base rate, base axes, rad/s."""
    r_S: Float[np.ndarray, "n 3"]
    """Position of S, m."""
    v_S: Float[np.ndarray, "n 3"]
    qd_rw: Float[np.ndarray, "n wheels"]

    def thinned(self, most: int) -> "MotionHistory":
        """The motion at no more than `most` of its times, evenly chosen."""
        chosen = np.arange(0, self.t.size, -(-self.t.size // most))
        return MotionHistory(*(column[chosen] for column in self))

    def wheel_angles(self) -> Float[np.ndarray, "n wheels"]:
        """What the wheels have turned since the first time, rad."""
        middle = (self.qd_rw[1:] + self.qd_rw[:-1]) / 2
        turned = np.cumsum(middle * np.diff(self.t)[:, None], axis=0)
        return np.vstack([np.zeros(self.qd_rw.shape[1]), turned])


class FramePoses(NamedTuple):
    """The frames of a scene, in the inertial frame."""

    R: Float[np.ndarray, "n frames 3 3"]
    p: Float[np.ndarray, "n frames 3"]


class CentroidalMomentum(NamedTuple):
    """The system CM, and momentum about and of it; inertial axes."""

    r_cm: Float[np.ndarray, "n 3"]
    """m."""
    h_rs: Float[np.ndarray, "n 3"]
    """Momentum of the bodies (Eq. 3), N m s."""
    h_rw: Float[np.ndarray, "n 3"]
    """Momentum of the wheels' relative spin (Eq. 5), N m s."""
    p: Float[np.ndarray, "n 3"]
    """Linear momentum, N s."""


def placed(
    scene: Scene, motion: MotionHistory, wheel_angles: Float[np.ndarray, "n wheels"]
) -> FramePoses:
    """Every frame of the scene.

    Args:
        scene: of the robot.
        motion: its times, joints, attitude and place.
        wheel_angles: how far each wheel is turned, rad.
    """
    at, n = poses(scene.robot, motion.q), len(motion.q)
    z = np.broadcast_to([0.0, 0.0, 1.0], (n, *scene.p_BWheel.shape))
    turned = scene.R_BWheel @ axis_rotation(z, wheel_angles)
    p_BWheel = np.broadcast_to(scene.p_BWheel, (n, *scene.p_BWheel.shape))
    R = np.concatenate([at.R, turned], axis=1)
    p = np.concatenate([at.d, p_BWheel], axis=1)
    R_WB = quaternion_matrix(motion.x_WB)[:, None]
    return FramePoses(R_WB @ R, motion.r_S[:, None] + rotate(R_WB, p))


def centroidal_momentum(robot: Robot, motion: MotionHistory) -> CentroidalMomentum:
    """The CM and the momentum of a robot with the inertia of `robot.theta`.

    In the plane only what the table leaves free: angular momentum about z, linear
    momentum along x and y.
    """
    at, R_WB = inertia(robot, motion.q), quaternion_matrix(motion.x_WB)
    h_rs = rotate(at.D, motion.w) + rotate(at.D_q, motion.qd)
    v_cm_S = np.cross(motion.w, at.r_cm) + rotate(at.J_cm, motion.qd)
    found = CentroidalMomentum(
        r_cm=motion.r_S + rotate(R_WB, at.r_cm),
        h_rs=rotate(R_WB, h_rs),
        h_rw=rotate(R_WB, motion.qd_rw @ wheels_of(robot).A_rw.T),
        p=robot.mass * (motion.v_S + rotate(R_WB, v_cm_S)),
    )
    if robot.motion == "planar":
        found.h_rs[:, :2] = found.h_rw[:, :2] = found.p[:, 2] = 0.0
    return found
