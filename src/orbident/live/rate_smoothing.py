"""The base rate with less noise: a polynomial through half a second on either side.

The filter takes noise in a regressor for excitation, and a rate that lags behind for
another one: a rate smoothed from the past alone misleads it worse than none. So a
sample waits until half a second more has come.
"""

import numpy as np
from jaxtyping import Bool, Float

HALF = 0.5
"""s, on either side. Bases of robots hardly change their rate faster."""

REACH = HALF + 0.5e-6
"""s: times have microseconds, so that rounding does not decide which samples count."""

DEGREE = 4
"""Of the polynomial, in time."""

HANKEL = np.add.outer(np.arange(DEGREE + 1), np.arange(DEGREE + 1))
"""Which power's sum stands where in the normal equations."""

FEWEST = 2 * (DEGREE + 1)
"""Samples: with fewer the polynomial follows the noise."""

JUMP = 0.01
"""rad/s: no base leaves its neighbours' median by so much and comes back at once."""

BESIDE = 2
"""Samples on either side that tell whether one is a spike."""


def ready(t: Float[np.ndarray, " n"]) -> int:
    """How many of these samples, in the order of their times, need wait no more."""
    waiting = np.searchsorted(t, t + REACH) + BESIDE > t.size
    return int(waiting.argmax()) if waiting.any() else t.size


def still_needed(t: Float[np.ndarray, " n"]) -> int:
    """The first of these samples that later ones need."""
    if not t.size:
        return 0
    return max(0, int(np.searchsorted(t, t[-1] - REACH)) - BESIDE)


def smoothed_at(
    t: Float[np.ndarray, " n"], w: Float[np.ndarray, "n 3"], first: int, last: int
) -> Float[np.ndarray, "some 3"]:
    """The rate at some of these samples; NaN where too few are near.

    Samples of the gyro, `w`, rad/s, are in the order of their times, s. Those from
    `first` on, up to the one before `last`, are all ready.
    """
    usable = _usable(w)
    begins, ends = (
        np.searchsorted(t, t[first:last] + reach) for reach in (-REACH, REACH)
    )
    rates = np.full((last - first, 3), np.nan)
    for k, (start, end) in enumerate(zip(begins, ends, strict=True)):
        near = usable[start:end]
        x = (t[start:end][near] - t[first + k]) / HALF
        if x.size >= FEWEST and np.ptp(x) > 1:
            rates[k] = _constant_term(x, w[start:end][near])
    return rates


def _constant_term(
    x: Float[np.ndarray, " n"], w: Float[np.ndarray, "n 3"]
) -> Float[np.ndarray, "3"]:
    """The polynomial's value at zero, by normal equations.

    Sums along a row are of the same bits wherever it lies. Products of matrices would
    give other bits for the same numbers at another address.
    """
    powers = np.empty((2 * DEGREE + 1, x.size))
    powers[0] = 1.0
    for k in range(2 * DEGREE):
        np.multiply(powers[k], x, out=powers[k + 1])
    sums = powers.sum(axis=1)
    columns = np.ascontiguousarray(w.T)
    right = (powers[: DEGREE + 1, None] * columns).sum(axis=2)
    return np.linalg.solve(sums[HANKEL], right)[0]


def _usable(w: Float[np.ndarray, "n 3"]) -> Bool[np.ndarray, " n"]:
    """Samples that are near the median of themselves and those beside them."""
    padded = np.pad(w, ((BESIDE, BESIDE), (0, 0)), constant_values=np.nan)
    near = np.stack([padded[k : k + len(w)] for k in range(2 * BESIDE + 1)])
    middle = np.sort(np.where(np.isnan(near), w, near), axis=0)[BESIDE]
    return (np.abs(w - middle) < JUMP).all(axis=1)
