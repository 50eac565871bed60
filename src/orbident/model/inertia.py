"""The inertia-type matrices of Eqs. 3, 5 and 6, and the system CM."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident import _core
from orbident.model.core_robot import core_robot
from orbident.robot.description import Robot
from orbident.threads import processors


class Inertia(NamedTuple):
    """The inertia of the system at some configurations, base axes.

    `h_rs = D w + D_q qd` about the system CM (Eq. 3); kinetic energy about the CM
    `1/2 w D w + w D_q qd + 1/2 qd D_qq qd` (Eq. 6, wheels apart).
    """

    D: Float[np.ndarray, "n 3 3"]
    D_q: Float[np.ndarray, "n 3 joints"]
    D_qq: Float[np.ndarray, "n joints joints"]
    r_cm: Float[np.ndarray, "n 3"]
    """Vector from S to the system CM, m."""
    J_cm: Float[np.ndarray, "n 3 joints"]
    """Velocity of the CM relative to S is `w x r_cm + J_cm qd`."""


def inertia(robot: Robot, q: Float[np.ndarray, "n joints"]) -> Inertia:
    """The matrices of `robot.theta` at the joint positions `q` (rad or m)."""
    return Inertia(
        *_core.inertia(core_robot(robot), np.ascontiguousarray(q), processors())
    )


def inertia_at(robot: Robot, q: Float[np.ndarray, " joints"]) -> Inertia:
    """The same at one configuration; no leading axis."""
    return Inertia(*(part[0] for part in inertia(robot, q[None])))


class Masses(NamedTuple):
    """Mass, first moment and inertia of some bodies about S, base axes."""

    m: Float[np.ndarray, "n bodies"]
    s: Float[np.ndarray, "n bodies 3"]
    J: Float[np.ndarray, "n bodies 3 3"]


def masses_about_S(robot: Robot, q: Float[np.ndarray, "n joints"]) -> Masses:
    """Each body's `theta_i`, moved from its body frame to S and base axes."""
    return Masses(*_core.masses(core_robot(robot), np.ascontiguousarray(q), False))


def carried_about_S(robot: Robot, q: Float[np.ndarray, "n joints"]) -> Masses:
    """The composite of each body: itself and all bodies that it carries."""
    return Masses(*_core.masses(core_robot(robot), np.ascontiguousarray(q), True))
