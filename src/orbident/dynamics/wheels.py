"""Reaction wheels as arrays: only their relative spin adds momentum (Eq. 5)."""

import equinox as eqx
import numpy as np
from jaxtyping import Float

from orbident.robot.description import Robot
from orbident.spatial.arrays import AnyArray


class Wheels(eqx.Module):
    """The reaction wheels of a base."""

    axes: Float[AnyArray, "3 wheels"]
    """Unit vectors, base axes."""
    A_rw: Float[AnyArray, "3 wheels"]
    """Columns `a_i I_rw,i`: `h_rw = A_rw qd_rw`, base axes."""
    free: Float[AnyArray, " wheels"]
    """1 for a wheel whose motor is off, 0 for one held at its relative speed."""


def wheels_of(robot: Robot) -> Wheels:
    """The robot's reaction wheels."""
    axes = np.reshape([wheel.axis for wheel in robot.wheels], (-1, 3)).T
    inertia = np.array([wheel.inertia for wheel in robot.wheels], dtype=float)
    free = np.array([float(wheel.mode == "free") for wheel in robot.wheels])
    return Wheels(axes, axes * inertia, free)
