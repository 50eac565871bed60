"""Where everything is over time: bodies, wheels, the system CM and momentum."""

from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from orbident.compilation import compiled
from orbident.dynamics.batches import in_batches
from orbident.dynamics.inertia import inertia
from orbident.dynamics.tree import Tree, poses, tree_of
from orbident.dynamics.wheels import Wheels, wheels_of
from orbident.precision import in_float64
from orbident.robot.description import Robot
from orbident.scene.scene import Scene
from orbident.spatial.arrays import AnyArray
from orbident.spatial.rotations import (
    axis_rotation,
    cross,
    product,
    quaternion_matrix,
    rotate,
)


class Motion(NamedTuple):
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

    def thinned(self, most: int) -> "Motion":
        """At no more than so many of the times, evenly chosen."""
        chosen = np.arange(0, self.t.size, -(-self.t.size // most))
        return Motion(*(column[chosen] for column in self))

    def wheel_angles(self) -> Float[np.ndarray, "n wheels"]:
        """What the wheels have turned since the first time, rad."""
        middle = (self.qd_rw[1:] + self.qd_rw[:-1]) / 2
        turned = np.cumsum(middle * np.diff(self.t)[:, None], axis=0)
        return np.vstack([np.zeros(self.qd_rw.shape[1]), turned])


class Placed(NamedTuple):
    """The frames of a scene, in the inertial frame."""

    R: Float[np.ndarray, "n frames 3 3"]
    p: Float[np.ndarray, "n frames 3"]


class Momentum(NamedTuple):
    """The system CM, and momentum about and of it; inertial axes."""

    r_cm: Float[np.ndarray, "n 3"]
    """m."""
    h_rs: Float[np.ndarray, "n 3"]
    """Of the bodies (Eq. 3), N m s."""
    h_rw: Float[np.ndarray, "n 3"]
    """Of the wheels' relative spin (Eq. 5), N m s."""
    p: Float[np.ndarray, "n 3"]
    """Linear momentum, N s."""


@in_float64
def placed(
    scene: Scene, motion: Motion, wheel_angles: Float[np.ndarray, "n wheels"]
) -> Placed:
    """Every frame of the scene.

    Args:
        scene: of the robot.
        motion: its times, joints, attitude and place.
        wheel_angles: how far each wheel is turned, rad.
    """
    function = partial(_placed, tree_of(scene.robot), scene.R_BWheel, scene.p_BWheel)
    return Placed(
        *in_batches(function, motion.q, motion.x_WB, motion.r_S, wheel_angles)
    )


@compiled
def _placed(
    tree: Tree,
    R_BWheel: Float[AnyArray, "wheels 3 3"],
    p_BWheel: Float[AnyArray, "wheels 3"],
    q: Float[AnyArray, "n joints"],
    x_WB: Float[AnyArray, "n 4"],
    r_S: Float[AnyArray, "n 3"],
    angles: Float[AnyArray, "n wheels"],
) -> tuple[Float[AnyArray, "n frames 3 3"], Float[AnyArray, "n frames 3"]]:
    z = jnp.broadcast_to(jnp.array([0.0, 0.0, 1.0]), p_BWheel.shape)

    def place(q, x_WB, r_S, angles):
        at, R_WB = poses(tree, q), quaternion_matrix(x_WB)
        turned = product(R_BWheel, axis_rotation(z, angles))
        R = jnp.concatenate([at.R, turned])
        p = jnp.concatenate([at.d, p_BWheel])
        return product(R_WB[None], R), r_S + rotate(R_WB[None], p)

    return jax.vmap(place)(q, x_WB, r_S, angles)


@in_float64
def momentum(robot: Robot, motion: Motion) -> Momentum:
    """The CM and the momentum of a robot with the inertia of `robot.theta`.

    In the plane only what the table leaves free: angular momentum about z, linear
    momentum along x and y.
    """
    function = partial(_momentum, tree_of(robot), robot.theta, wheels_of(robot))
    found = Momentum(*in_batches(function, motion))
    if robot.motion == "planar":
        found.h_rs[:, :2] = found.h_rw[:, :2] = found.p[:, 2] = 0.0
    return found


@compiled
def _momentum(
    tree: Tree, theta: Float[AnyArray, "bodies 10"], wheels: Wheels, motion: Motion
) -> tuple[Float[AnyArray, "n 3"], ...]:
    def each(motion: Motion):
        at, R_WB = inertia(tree, theta, motion.q), quaternion_matrix(motion.x_WB)
        h_rs = at.D @ motion.w + at.D_q @ motion.qd
        v_cm = motion.v_S + rotate(R_WB, cross(motion.w, at.r_cm) + at.J_cm @ motion.qd)
        return (
            motion.r_S + rotate(R_WB, at.r_cm),
            rotate(R_WB, h_rs),
            rotate(R_WB, wheels.A_rw @ motion.qd_rw),
            at.M * v_cm,
        )

    return jax.vmap(each)(motion)
