"""Derivatives of samples by a polynomial through the neighbours of each.

The sample itself is left out: with it, its noise would be in what it is compared with,
and would seem to be explained by itself.
"""

import numpy as np
from jaxtyping import Float

HALF, DEGREE = 8, 4
"""Samples before and after one, and the degree of the polynomial through them."""

Samples = Float[np.ndarray, "n axes"]


def derivatives(t: Float[np.ndarray, " n"], x: Samples) -> tuple[Samples, Samples]:
    """The first and the second derivative by time.

    Args:
        t: s, evenly spaced; more than `2 HALF`.
        x: finite samples at these times.
    """
    dt = float(np.median(np.diff(t)))
    k = np.delete(np.arange(-HALF, HALF + 1), HALF) / HALF
    by = np.linalg.pinv(np.vander(k, DEGREE + 1, increasing=True))
    by = np.insert(by, HALF, 0.0, axis=1)
    around = ((HALF, HALF), (0, 0))
    padded = np.pad(x, around, mode="reflect", reflect_type="odd")

    def filtered(weights: Float[np.ndarray, " around"]) -> Samples:
        columns = [np.correlate(axis, weights, "valid") for axis in padded.T]
        return np.column_stack(columns)

    return filtered(by[1] / (HALF * dt)), filtered(2 * by[2] / (HALF * dt) ** 2)
