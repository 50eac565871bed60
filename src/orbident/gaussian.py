"""Numbers of the normal distribution, and the white noise that samples show."""

import numpy as np
from jaxtyping import Float

NINETY_FIVE = 1.96
"""So many standard deviations to either side hold 95 %."""

OF_MEDIAN = 1.4826
"""The standard deviation over the median absolute value."""


def white_std(samples: Float[np.ndarray, "samples ..."]) -> Float[np.ndarray, " ..."]:
    """Std of the white noise of each column, from fourth differences.

    A motion hardly has any, and those of white noise have 1 + 16 + 36 + 16 + 1 = 70
    times its variance.

    Args:
        samples: evenly spaced, five at least; any unit.
    """
    bends = np.median(np.abs(np.diff(samples, n=4, axis=0)), axis=0)
    return np.asarray(OF_MEDIAN * bends / np.sqrt(70))
