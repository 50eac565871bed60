"""Is the nominal mass matrix one that a mechanism can have?"""

import jax
import numpy as np

from orbident.dynamics.inertia import inertia
from orbident.dynamics.tree import tree_of
from orbident.errors import InputError
from orbident.precision import in_float64
from orbident.robot.description import Robot

# Of the mass matrix with unit diagonal: real arms reach 1e-6, rounding is 1e-16.
SINGULAR = 1e-12

_inertia = jax.jit(inertia)


@in_float64
def check_regular(robot: Robot) -> None:
    """Refuse a robot whose mass matrix is singular.

    Raises:
        InputError: some motion of base and joints moves no mass at all.
    """
    q = np.random.default_rng(0).standard_normal(len(robot.joints))
    at = _inertia(tree_of(robot), robot.theta, q)
    turning = [2] if robot.motion == "planar" else [0, 1, 2]
    D, D_q = np.asarray(at.D)[np.ix_(turning, turning)], np.asarray(at.D_q)[turning]
    H = np.block([[D, D_q], [D_q.T, np.asarray(at.D_qq)]])
    names = [f"the base about {'xyz'[k]}" for k in turning]
    names += [f"joint '{name}'" for name in robot.joint_names]
    scale = np.abs(np.diag(H))
    still = scale <= SINGULAR * scale.max()
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
