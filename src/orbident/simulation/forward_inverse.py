"""Accelerations that follow from forces, and forces from accelerations (Eq. 13)."""

import numpy as np
from jaxtyping import Float

from orbident import _core
from orbident.model.core_robot import core_robot
from orbident.model.equations_of_motion import equations_of_motion, movable
from orbident.robot.description import Robot
from orbident.threads import processors


def forward_dynamics(
    robot: Robot,
    q: Float[np.ndarray, "n joints"],
    v: Float[np.ndarray, "n speeds"],
    Q: Float[np.ndarray, "n speeds"],
) -> Float[np.ndarray, "n speeds"]:
    """`v' = H+^-1 (Q - c+)`; in the plane, of what can move.

    Args:
        robot: its `theta` decides.
        q: joint positions, rad or m.
        v: generalised speeds, base axes.
        Q: generalised forces, base axes.
    """
    free = movable(robot).astype(float)
    return hybrid_dynamics(robot, q, v, Q, np.zeros_like(v), free)[0]


def inverse_dynamics(
    robot: Robot,
    q: Float[np.ndarray, "n joints"],
    v: Float[np.ndarray, "n speeds"],
    vd: Float[np.ndarray, "n speeds"],
) -> Float[np.ndarray, "n speeds"]:
    """`Q = H+ v' + c+`: what it takes; in the plane, with what the plane bears.

    Args:
        robot: its `theta` decides.
        q: joint positions, rad or m.
        v: generalised speeds, base axes.
        vd: their derivatives.
    """
    at = equations_of_motion(robot, q, v)
    return np.einsum("nij,nj->ni", at.H, vd) + at.c


def hybrid_dynamics(
    robot: Robot,
    q: Float[np.ndarray, "n joints"],
    v: Float[np.ndarray, "n speeds"],
    Q: Float[np.ndarray, "n speeds"],
    vd: Float[np.ndarray, "n speeds"],
    free: Float[np.ndarray, " speeds"],
) -> tuple[Float[np.ndarray, "n speeds"], Float[np.ndarray, "n 3"]]:
    """`v'` where some of it is known and elsewhere the force is; acceleration of S.

    Args:
        robot: its `theta` decides.
        q: joint positions, rad or m.
        v: generalised speeds, base axes.
        Q: the forces where `free` is 1.
        vd: the accelerations where `free` is 0.
        free: 1 or 0 for each speed.

    Returns:
        `v'`, and the acceleration of S, base axes, m/s^2.
    """
    return _core.forward_dynamics(core_robot(robot), q, v, Q, vd, free, processors())
