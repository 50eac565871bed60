"""Numbers of the normal distribution, and the white noise that samples show."""

import math

import numpy as np
from jaxtyping import Float

NINETY_FIVE = 1.96
"""So many standard deviations to either side hold 95 %."""

OF_MEDIAN = 1.4826
"""The standard deviation over the median absolute value."""


def white_std_of(
    differences: Float[np.ndarray, "n ..."], order: int, axis: int | None = None
) -> Float[np.ndarray, " ..."]:
    """Std of the white noise whose differences of some order these are, in their unit.

    A smooth motion has the less of them the higher the order. Those of white noise have
    `C(2 order, order)` times its variance: 2, 6, 20, 70. Outliers hardly count. The
    median is taken along `axis`, or of all of them where it is None.
    """
    typical = np.median(np.abs(differences), axis=axis)
    return np.asarray(OF_MEDIAN * typical / np.sqrt(math.comb(2 * order, order)))


def white_std(samples: Float[np.ndarray, "samples ..."]) -> Float[np.ndarray, " ..."]:
    """Std of the white noise of each column, from fourth differences.

    Samples are evenly spaced, five at least, in any unit.
    """
    return white_std_of(np.diff(samples, n=4, axis=0), 4, axis=0)


def noisiest_std(samples: Float[np.ndarray, "samples axes"]) -> float:
    """Std of the white noise of the noisiest axis: in the plane some show nothing.

    It is zero where there are less than five samples.
    """
    return float(white_std(samples).max()) if len(samples) >= 5 else 0.0


def rms_of(vectors: Float[np.ndarray, "n axes"]) -> float:
    """The root mean square of the vectors' lengths; NaN where there are none."""
    if not len(vectors):
        return np.nan
    return float(np.sqrt(np.mean(np.sum(vectors**2, axis=1))))
