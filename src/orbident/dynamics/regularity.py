"""Is the nominal mass matrix one that a mechanism can have?"""

import numpy as np
from jaxtyping import Float

from orbident.compilation import compiled
from orbident.dynamics.inertia import inertia, masses_about_S
from orbident.dynamics.tree import Tree, poses, tree_of
from orbident.errors import InputError
from orbident.precision import in_float64
from orbident.robot.description import Robot
from orbident.spatial.arrays import AnyArray

# Of the mass matrix with unit diagonal: real arms reach 1e-6, rounding is 1e-16.
SINGULAR = 1e-12

_inertia = compiled(inertia)


@in_float64
def check_regular(robot: Robot) -> None:
    """Refuse a robot whose mass matrix is singular.

    Raises:
        InputError: some motion of base and joints moves no mass at all.
    """
    tree = tree_of(robot)
    q = np.random.default_rng(0).standard_normal(len(robot.joints))
    at = _inertia(tree, robot.theta, q)
    turning = [2] if robot.motion == "planar" else [0, 1, 2]
    D, D_q = np.asarray(at.D)[np.ix_(turning, turning)], np.asarray(at.D_q)[turning]
    H = np.block([[D, D_q], [D_q.T, np.asarray(at.D_qq)]])
    names = [f"the base about {'xyz'[k]}" for k in turning]
    names += [f"joint '{name}'" for name in robot.joint_names]
    base, carried = (np.asarray(size) for size in _sizes(tree, robot.theta, q))
    sizes = np.concatenate([np.full(len(turning), base), carried])
    scale = np.abs(np.diag(H))
    still = scale <= SINGULAR * sizes
    if still.any():
        _refuse(robot, names[int(still.argmax())])
    unit = H / np.sqrt(np.outer(scale, scale))
    values, vectors = np.linalg.eigh(unit)
    smallest = int(np.abs(values).argmin())
    if abs(values[smallest]) <= SINGULAR:
        _refuse(robot, names[int(np.abs(vectors[:, smallest]).argmax())])


def _refuse(robot: Robot, who: str) -> None:
    raise InputError(
        f"{robot.name}: the mass matrix is singular: {who} can turn or slide without "
        "moving any mass; give the links beyond it an inertia, or make the joint fixed"
    )


@compiled
def _sizes(
    tree: Tree, theta: Float[AnyArray, "bodies 10"], q: Float[AnyArray, " joints"]
) -> tuple[Float[AnyArray, ""], Float[AnyArray, " joints"]]:
    """What the diagonal is made of, before anything cancels: of base and joints."""
    bodies = masses_about_S(poses(tree, q), theta)
    spread = bodies.J.trace(axis1=-2, axis2=-1)
    turns = tree.revolute * (tree.moves @ spread)
    return spread.sum(), turns + (1 - tree.revolute) * (tree.moves @ bodies.m)
