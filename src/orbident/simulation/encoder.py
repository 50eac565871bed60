"""Encoders of joints and wheels."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from orbident.simulation.noise_processes import gaussian, quantised
from orbident.simulation.sensor import Sensor, require


@dataclass(frozen=True, kw_only=True)
class Encoder(Sensor):
    """An angle (or, of a prismatic joint, a length), its rate, or both.

    `shown = resolution round((true + n) / resolution)`, `n ~ N(0, position^2)`. Wheels
    are counted over full turns. The paper's encoders show no rates (Section 3.5).

    Raises:
        InputError: a value is negative or not a number.
    """

    position: float | None = None
    """Std of the angle's noise, rad or m; None where only the rate is read."""
    resolution: float = 0.0
    """One count, rad or m; zero for a continuous reading."""
    tachometer: float | None = None
    """Std of the rate's noise, rad/s or m/s; None where no rate is read."""

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self, "resolution")
        for name in ("position", "tachometer"):
            if getattr(self, name) is not None:
                require(self, name)

    def read(
        self,
        true: Float[np.ndarray, "n axes"],
        dt: float,
        random: np.random.Generator,
    ) -> Float[np.ndarray, "n axes"]:
        """Angles, rad, or lengths, m; `dt` does not matter."""
        noisy = true + gaussian(random, true.shape, self.position or 0.0)
        return quantised(noisy, self.resolution)

    def read_rates(
        self,
        true: Float[np.ndarray, "n axes"],
        dt: float,
        random: np.random.Generator,
    ) -> Float[np.ndarray, "n axes"]:
        """Rates, rad/s or m/s; `dt` does not matter."""
        return true + gaussian(random, true.shape, self.tachometer or 0.0)
