"""Reaction wheels as arrays: only their relative spin adds momentum (Eq. 5)."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.robot.description import Robot


class Wheels(NamedTuple):
    """The reaction wheels of a base."""

    axes: Float[np.ndarray, "3 wheels"]
    """Unit vectors, base axes."""
    A_rw: Float[np.ndarray, "3 wheels"]
    """Columns `a_i I_rw,i`: `h_rw = A_rw qd_rw`, base axes."""
    inertia: Float[np.ndarray, " wheels"]
    """Polar moments of inertia `I_rw,i`, kg m^2."""
    free: Float[np.ndarray, " wheels"]
    """1 for a wheel whose motor is off, 0 for one held at its relative speed."""


def wheels_of(robot: Robot) -> Wheels:
    """The robot's reaction wheels."""
    axes = np.reshape([wheel.axis for wheel in robot.wheels], (-1, 3)).T
    inertia = np.array([wheel.inertia for wheel in robot.wheels], dtype=float)
    free = np.array([float(wheel.mode == "free") for wheel in robot.wheels])
    return Wheels(axes, axes * inertia, inertia, free)
