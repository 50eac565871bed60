"""Velocities of the bodies, as fields seen from the feature point S.

A rigid motion is its angular velocity `w` and the velocity `u` that its field has at
S. Everything is in base axes and relative to S, whose own velocity drops out.
"""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Float

from orbident.dynamics.tree import Poses, Tree, poses
from orbident.spatial.arrays import AnyArray
from orbident.spatial.rotations import cross, rotate


class JointFields(eqx.Module):
    """The motion that a unit rate of each joint gives to all that it carries."""

    w: Float[AnyArray, "joints 3"]
    u: Float[AnyArray, "joints 3"]


def joint_fields(tree: Tree, at: Poses) -> JointFields:
    """Revolute: `w = a`, `u = d x a`; prismatic: `w = 0`, `u = a`."""
    a = rotate(at.R[1:], tree.axis)
    turns = tree.revolute[:, None]
    return JointFields(turns * a, turns * cross(at.d[1:], a) + (1 - turns) * a)


class Velocities(eqx.Module):
    """Of every body: angular velocity, and velocity of its origin relative to S."""

    w: Float[AnyArray, "bodies 3"]
    v: Float[AnyArray, "bodies 3"]


def velocities(
    tree: Tree, at: Poses, qd: Float[AnyArray, " joints"], w: Float[AnyArray, "3"]
) -> Velocities:
    """Body velocities at joint rates `qd` and base rate `w` (rad/s, base axes)."""
    fields = joint_fields(tree, at)
    w_i = w + tree.moves.T @ (fields.w * qd[:, None])
    u_i = tree.moves.T @ (fields.u * qd[:, None])
    return Velocities(w_i, u_i + cross(w_i, at.d))


def point_jacobian(
    tree: Tree,
    q: Float[AnyArray, " joints"],
    body: int,
    p: Float[AnyArray, "3"],
) -> Float[AnyArray, "6 3+joints"]:
    """Velocity of a body-fixed point relative to S, over `[w, qd]`.

    Args:
        tree: the robot's geometry.
        q: joint positions, rad or m.
        body: index of the body.
        p: the point in the body's frame, m.

    Returns:
        Rows: linear velocity relative to S, then angular velocity, base axes.
    """
    at = poses(tree, q)
    fields = joint_fields(tree, at)
    r = at.d[body] + rotate(at.R[body], p)
    carried = tree.moves[:, body][:, None]
    linear = carried * (fields.u + cross(fields.w, r[None]))
    eye = jnp.eye(3, dtype=r.dtype)
    base = jnp.concatenate([cross(eye, r[None]).T, eye])
    joints = jnp.concatenate([linear.T, (carried * fields.w).T])
    return jnp.concatenate([base, joints], axis=1)
