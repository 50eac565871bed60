"""What was measured and what is predicted of it, as data."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float


class Signal(NamedTuple):
    """One sensor, or one equation, at its own times.

    Of an attitude the measured one is the turn by which it is off the predicted one,
    which is zero: rotation vectors in base axes.
    """

    name: str
    axes: tuple[str, ...]
    units: tuple[str, ...]
    """Units of the axes."""
    t: Float[np.ndarray, " n"]
    """s."""
    measured: Float[np.ndarray, "n axes"]
    predicted: Float[np.ndarray, "n axes"]
    std: float
    """Deviation of the noise that the residuals show."""

    def __repr__(self) -> str:
        """Which axes, and how often."""
        axes = zip(self.axes, self.units, strict=True)
        named = ", ".join(f"{axis} ({unit})" for axis, unit in axes)
        return f"{self.name}: {named}; {self.t.size} samples, noise {self.std:.2g}"

    @property
    def sensor(self) -> str:
        """The name, without that of its recording where there are several."""
        return sensor_of(self.name)


def sensor_of(name: str) -> str:
    """`gyro` of `second flight: gyro`."""
    return name.rpartition(": ")[2]


Signals = tuple[Signal, ...]
