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

    Times `t`, s, are evenly spaced and more than `2 HALF`; the samples are finite.
    """
    k = np.delete(np.arange(-HALF, HALF + 1), HALF) / HALF
    by = np.linalg.pinv(np.vander(k, DEGREE + 1, increasing=True))
    scale = HALF * float(np.median(np.diff(t)))
    order = np.array([[1.0 / scale], [2.0 / scale**2]])
    padded = np.pad(x, ((HALF, HALF), (0, 0)), mode="reflect", reflect_type="odd")
    first, second = (
        np.column_stack([np.correlate(axis, weights, "valid") for axis in padded.T])
        for weights in np.insert(by, HALF, 0.0, axis=1)[1:3] * order
    )
    return first, second
