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
    first, second = _weights(t, HALF)
    return _filtered(x, first), _filtered(x, second)


def _weights(t: Float[np.ndarray, " n"], half: int) -> Float[np.ndarray, "2 around"]:
    """What neighbours of a sample weigh in the first and second derivative there."""
    k = np.delete(np.arange(-half, half + 1), half) / half
    by = np.linalg.pinv(np.vander(k, DEGREE + 1, increasing=True))
    scale = half * float(np.median(np.diff(t)))
    order = np.array([[1.0 / scale], [2.0 / scale**2]])
    return np.insert(by, half, 0.0, axis=1)[1:3] * order


def _filtered(x: Samples, weights: Float[np.ndarray, " around"]) -> Samples:
    half = weights.size // 2
    padded = np.pad(x, ((half, half), (0, 0)), mode="reflect", reflect_type="odd")
    columns = [np.correlate(axis, weights, "valid") for axis in padded.T]
    return np.column_stack(columns)
