"""What all sensors have in common: when they sample, how late, and how surely."""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.interpolate import CubicSpline

from orbident.errors import InputError

_ROUNDING = 1e-6

Reading = Callable[
    [Float[np.ndarray, "n true"], float, np.random.Generator],
    Float[np.ndarray, "n axes"],
]
"""What a sensor shows of true values `dt` apart."""


@dataclass(frozen=True, kw_only=True)
class Sensor(ABC):
    """A sensor that samples evenly, on every k-th row of a recording.

    Raises:
        InputError: a value is not a number of zero or more, the rate is zero, or the
            probability of a drop-out is above one.
    """

    rate: float | None = None
    """Samples per second, Hz; one on every row where it is not given."""
    latency: float = 0.0
    """A sample shows the world as it was so long ago, s."""
    drop_out: float = 0.0
    """Probability that a sample is missing, each for itself."""

    def __post_init__(self) -> None:
        if self.rate is not None:
            require(self, "rate", above_zero=True)
        require(self, "latency")
        require(self, "drop_out")
        if self.drop_out > 1.0:
            raise InputError(
                f"drop_out: found {self.drop_out}; give a probability, from 0 to 1"
            )

    @abstractmethod
    def read(
        self,
        true: Float[np.ndarray, "n axes"],
        dt: float,
        random: np.random.Generator,
    ) -> Float[np.ndarray, "n axes"]:
        """What the sensor shows of true values `dt` seconds apart."""

    def sample(
        self,
        t: Float[np.ndarray, " rows"],
        true: Float[np.ndarray, "rows true"],
        random: np.random.Generator,
        read: Reading | None = None,
    ) -> Float[np.ndarray, "rows axes"]:
        """The sensor's columns of a recording.

        Args:
            t: times of the rows, evenly spaced, s.
            true: the noise-free values at the rows.
            random: the sensor's stream.
            read: instead of the sensor's own `read`.

        Returns:
            The samples; NaN on rows without one.

        Raises:
            InputError: the rows are not evenly spaced, or the rate is not theirs
                divided by a whole number.
        """
        noise, losses = random.spawn(2)
        stride, dt = self._stride(t)
        rows = slice(None, None, stride)
        true = _delayed(t, true, t[rows], self.latency) if self.latency else true[rows]
        shown = (read or self.read)(true, dt, noise)
        shown = np.where(losses.random((len(shown), 1)) < self.drop_out, np.nan, shown)
        columns = np.full((t.size, shown.shape[1]), np.nan)
        columns[rows] = shown
        return columns

    def _stride(self, t: Float[np.ndarray, " rows"]) -> tuple[int, float]:
        """Rows from one sample to the next, and the time between these, s."""
        row = float(t[-1] - t[0]) / (t.size - 1)
        if np.abs(np.diff(t) - row).max() > _ROUNDING * row:
            raise InputError(
                f"rows are {np.diff(t).min():g} to {np.diff(t).max():g} s apart; "
                "sensors sample evenly, so simulate at a constant rate"
            )
        if self.rate is None:
            return 1, row
        stride = round(1 / (self.rate * row))
        if abs(stride * self.rate * row - 1) > _ROUNDING:
            raise InputError(
                f"rate: found {self.rate:g} Hz, but the recording has {1 / row:g} rows "
                "a second; give that divided by a whole number, or simulate at a "
                "multiple of the sensor's rate"
            )
        return stride, stride * row


def require(
    instance: object,
    name: str,
    *,
    above_zero: bool = False,
    infinite: bool = False,
) -> None:
    """Refuse an attribute that is not a number in SI of zero or more.

    Raises:
        InputError: so.
    """
    value = getattr(instance, name)
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if not number or not value >= 0 or (above_zero and value == 0):
        least = "above zero" if above_zero else "of zero or more"
        raise InputError(f"{name}: found {value!r}; give a number {least}, in SI")
    if math.isinf(value) and not infinite:
        raise InputError(f"{name}: found {value!r}; give a finite number, in SI")


def _delayed(
    t: Float[np.ndarray, " rows"],
    true: Float[np.ndarray, "rows axes"],
    at: Float[np.ndarray, " n"],
    latency: float,
) -> Float[np.ndarray, "n axes"]:
    """The values of so long ago; NaN where that is before the first row."""
    if t.size < 4:
        raise InputError(f"latency: needs at least 4 rows, found {t.size}")
    return CubicSpline(t, true, extrapolate=False)(at - latency)
