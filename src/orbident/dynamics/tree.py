"""The kinematic tree as arrays: the only file that knows tree order."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Int

from orbident.precision import require_float64
from orbident.robot.description import Robot
from orbident.spatial.arrays import AnyArray
from orbident.spatial.rotations import axis_rotation, product, rotate


class Tree(eqx.Module):
    """A robot's geometry, without its inertia. Joint `k` moves body `k + 1`."""

    parent: Int[AnyArray, " joints"]
    revolute: Float[AnyArray, " joints"]
    """1 for a revolute joint, 0 for a prismatic one."""
    axis: Float[AnyArray, "joints 3"]
    R_PJ: Float[AnyArray, "joints 3 3"]
    p_PJ: Float[AnyArray, "joints 3"]
    moves: Float[AnyArray, "joints bodies"]
    """1 where the joint moves the body: the body is at or below it."""


def tree_of(robot: Robot) -> Tree:
    """The robot's kinematic tree."""
    joints = robot.joints
    moves = np.zeros((len(joints), len(robot.bodies)))
    for k, joint in enumerate(joints):
        moves[:, k + 1] = moves[:, joint.parent]
        moves[k, k + 1] = 1.0
    return Tree(
        parent=np.array([joint.parent for joint in joints], dtype=np.int64),
        revolute=np.array([float(joint.kind == "revolute") for joint in joints]),
        axis=np.reshape([joint.axis for joint in joints], (-1, 3)),
        R_PJ=np.reshape([joint.R_PJ for joint in joints], (-1, 3, 3)),
        p_PJ=np.reshape([joint.p_PJ for joint in joints], (-1, 3)),
        moves=moves,
    )


class Poses(eqx.Module):
    """Where every body is, seen from the base: `R_Bi` and `p_SBi` in base axes."""

    R: Float[AnyArray, "bodies 3 3"]
    d: Float[AnyArray, "bodies 3"]


def poses(tree: Tree, q: Float[AnyArray, " joints"]) -> Poses:
    """Forward kinematics: one scan from the base to the tips, whatever the tree.

    Raises:
        InputError: `q` is not float64.
    """
    require_float64("kinematics", q=q)
    slide = (1 - tree.revolute) * q
    R_PC = product(tree.R_PJ, axis_rotation(tree.axis, tree.revolute * q))
    p_PC = tree.p_PJ + slide[:, None] * rotate(tree.R_PJ, tree.axis)

    # [R | p] as one array: one update a joint is what the scan costs.
    X_PC = jnp.concatenate([R_PC, p_PC[:, :, None]], axis=-1)

    def place(X_B, joint):
        k, parent, X_PC = joint
        X_BP = X_B[parent]
        X_BC = jnp.asarray(product(X_BP[:, :3], X_PC)).at[:, 3].add(X_BP[:, 3])
        return X_B.at[k + 1].set(X_BC), None

    X_BB = jnp.zeros((tree.moves.shape[1], 3, 4), q.dtype).at[0, :, :3].set(jnp.eye(3))
    order = jnp.arange(tree.parent.shape[0])
    X_B, _ = jax.lax.scan(place, X_BB, (order, tree.parent, X_PC))
    return Poses(X_B[:, :, :3], X_B[:, :, 3])
