"""Are residuals white? What a model leaves out is slow, as the motion is."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.estimation.levels import limit

LOW = 0.05
"""Part of all frequencies that counts as low: below 0.25 to 2.5 Hz at 10 to 100 Hz."""

FEWEST = 8
"""Low frequencies that can be told from chance."""

OUTLYING = 4.0
"""Deviations at which residuals are cut off, as maximum likelihood weighs them."""


class LowFrequencies(NamedTuple):
    """The power of residuals at low frequencies, over that of white noise."""

    ratio: float
    """The power of the axis on which it is largest."""
    limit: float


def low_frequencies(
    residuals: Float[np.ndarray, "n axes"], std: float
) -> LowFrequencies | None:
    """Test whether residuals are white noise at low frequencies.

    Of white noise the periodogram at `m` frequencies is independent from one to the
    next, and twice its sum over the noise's level is chi-square with `2 m` degrees of
    freedom (Priestley 1981, section 6.1). What a sensor's own unknowns take up makes
    it smaller.

    Args:
        residuals: of one sensor, evenly sampled but for gaps.
        std: of its noise, in the same unit.

    Returns:
        The ratio and its limit; None where there are too few samples.
    """
    n, axes = residuals.shape
    count = int(LOW * (n // 2))
    if count < FEWEST or not std > 0:
        return None
    cut = np.clip(residuals, -OUTLYING * std, OUTLYING * std)
    power = np.abs(np.fft.rfft(cut, axis=0)[1:]) ** 2
    level = np.mean(power, axis=0)
    ratio = np.max(np.mean(power[:count], axis=0) / np.where(level > 0, level, 1.0))
    most = limit("white residuals", 2 * count, axes) / (2 * count)
    return LowFrequencies(float(ratio), most)
