"""Encoders of joints and wheels."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from orbident.simulation.noise import gaussian, quantised
from orbident.simulation.sensor import Sensor, require


@dataclass(frozen=True, kw_only=True)
class Encoder(Sensor):
    """An angle (or, of a prismatic joint, a length), never a rate (Section 3.5).

    `shown = resolution round((true + n) / resolution)`, `n ~ N(0, position^2)`. Wheels
    are counted over full turns.

    Raises:
        InputError: a value is negative or not a number.
    """

    position: float
    """Std of the noise, rad or m."""
    resolution: float = 0.0
    """One count, rad or m; zero for a continuous reading."""

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self, "position")
        require(self, "resolution")

    def read(
        self,
        true: Float[np.ndarray, "n axes"],
        dt: float,
        random: np.random.Generator,
    ) -> Float[np.ndarray, "n axes"]:
        """Angles, rad, or lengths, m; `dt` does not matter."""
        noisy = true + gaussian(random, true.shape, self.position)
        return quantised(noisy, self.resolution)
