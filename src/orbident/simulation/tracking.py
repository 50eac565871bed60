"""Pose from outside: star trackers, motion capture, vision."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from orbident.model.rotations import quaternion_rate
from orbident.simulation.noise import gaussian
from orbident.simulation.sensor import Sensor, require


@dataclass(frozen=True, kw_only=True)
class AttitudeTracker(Sensor):
    """Orientation of the base in the inertial frame.

    `shown = true (x) exp(d / 2)`, `d ~ N(0, angle^2)` about each base axis.

    Raises:
        InputError: a value is negative or not a number.
    """

    angle: float
    """Std of the rotation about each axis, rad."""

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self, "angle")

    def read(
        self,
        true: Float[np.ndarray, "n axes"],
        dt: float,
        random: np.random.Generator,
    ) -> Float[np.ndarray, "n axes"]:
        """Unit quaternions, scalar last; `dt` does not matter."""
        x_WB = true / np.linalg.norm(true, axis=1, keepdims=True)
        d = gaussian(random, (len(true), 3), self.angle)
        half = np.linalg.norm(d, axis=1, keepdims=True) / 2
        # The product with (v, s) is s x + d/dt x at the rate 2 v; v = sin(half) d/|d|.
        v = np.sinc(half / np.pi) * d / 2
        return np.cos(half) * x_WB + quaternion_rate(x_WB, 2 * v)


@dataclass(frozen=True, kw_only=True)
class PositionTracker(Sensor):
    """Position of S in the inertial frame, m.

    Raises:
        InputError: a value is negative or not a number.
    """

    std: float
    """Of the noise on each axis, m."""

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self, "std")

    def read(
        self,
        true: Float[np.ndarray, "n axes"],
        dt: float,
        random: np.random.Generator,
    ) -> Float[np.ndarray, "n axes"]:
        """Positions, m; `dt` does not matter."""
        return true + gaussian(random, true.shape, self.std)
