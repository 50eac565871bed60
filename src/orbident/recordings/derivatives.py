"""Derivatives of samples by a polynomial through the neighbours of each.

The sample itself is left out: with it, its noise would be in what it is compared with,
and would seem to be explained by itself.
"""

import numpy as np
from jaxtyping import Float

from orbident.gaussian import white_std

HALF, DEGREE = 8, 4
"""Samples before and after one, and the degree of the polynomial through them."""

EXPLAINED = 1.5
"""How many times what noise explains two derivatives may differ: some twenty samples
know the noise better than that."""

Samples = Float[np.ndarray, "n axes"]


def derivatives(t: Float[np.ndarray, " n"], x: Samples) -> tuple[Samples, Samples]:
    """The first and the second derivative by time.

    Args:
        t: s, evenly spaced; more than `2 HALF`.
        x: finite samples at these times.
    """
    first, second = _weights(t, HALF)
    return _filtered(x, first), _filtered(x, second)


def second_derivative(t: Float[np.ndarray, " n"], x: Samples) -> Samples:
    """The second derivative of each axis by the widest polynomials that it allows.

    Each is twice as wide as the one before, and both differ by no more than the noise
    of the narrower one explains (Lepski 1991): what is wider is hardly noise, and what
    is narrower hardly bent otherwise.

    Args:
        t: s, evenly spaced; more than `2 HALF`.
        x: finite samples at these times.
    """
    return np.column_stack([_widest(t, axis[:, None]) for axis in x.T])


def _widest(t: Float[np.ndarray, " n"], x: Float[np.ndarray, "n 1"]) -> Samples:
    half, noise = HALF, white_std(x)
    by = _weights(t, half)[1]
    found = _filtered(x, by)
    while t.size > 4 * half:
        half = 2 * half
        wide = _weights(t, half)[1]
        more = _filtered(x, wide)
        own = noise * np.linalg.norm(wide - np.pad(by, half // 2))
        if np.sqrt(np.mean((more - found) ** 2)) > EXPLAINED * own:
            break
        found, by = more, wide
    return found


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
