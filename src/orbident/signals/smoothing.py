"""Position, rate and acceleration of columns, as smooth as their noise says."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.precision import in_float64
from orbident.signals.roughness import Column, most_likely
from orbident.signals.white_snap import (
    BLOCK,
    LANES,
    NOTHING_KNOWN,
    backward,
    final_estimate,
    forward,
)


class Smoothed(NamedTuple):
    """Columns at the times asked for; NaN where they would be extrapolated."""

    x: Float[np.ndarray, "m columns"]
    rate: Float[np.ndarray, "m columns"]
    """Per second."""
    acceleration: Float[np.ndarray, "m columns"]
    """Per second squared."""
    std_x: Float[np.ndarray, "m columns"]
    std_rate: Float[np.ndarray, "m columns"]
    noise_std: Float[np.ndarray, " columns"]
    """Of the samples: what was given, or what was found; NaN where 4 tell nothing."""


@in_float64
def smooth(
    t: Float[np.ndarray, " samples"],
    x: Float[np.ndarray, "samples columns"],
    std: float | Float[np.ndarray, " columns"] | None = None,
    at: Float[np.ndarray, " m"] | None = None,
    name: str = "x",
) -> Smoothed:
    """The smoothing spline of degree 7 of each column, with standard deviations.

    `sample = x + N(0, std^2)`, `x''''` white, nothing known at the start: the posterior
    mean is the smoothing spline (Wahba 1978). The density of `x''''` is the most likely
    one, so that the noise alone decides how smooth the result is; of more than 4096
    samples it is found from 4 stretches of 1024, or of averages of 8, or 64, or more.

    The standard deviations hold where the motion is equally smooth throughout. Next to
    a step of the acceleration they are too small.

    Args:
        t: times, s, strictly increasing.
        x: any unit; NaN where there is no sample. Each column is for itself.
        std: of the measurement noise, in the unit of `x`; estimated where it is None.
            Give a coarse encoder's: where its steps show, they do not look like noise.
        at: times to evaluate at, s, in any order; `t` by default.
        name: what `x` is, for messages.

    Returns:
        In the unit of `x`, and s.

    Raises:
        InputError: a column has fewer than 4 valid samples or infinite values, times
            do not increase or are not finite, or `std` is not positive.
    """
    _check_times(t, name)
    labels = [f"{name}[:, {k}]" for k in range(x.shape[1])]
    columns = [_column(t, x[:, k], label) for k, label in enumerate(labels)]
    given = _stds(std, len(columns), name)
    fits = [most_likely(column, s) for column, s in zip(columns, given, strict=True)]
    grid = t if at is None else np.union1d(t, at)
    if not np.isfinite(grid).all():
        raise InputError(f"{name}: asked for a time that is not finite; give seconds")
    mean, variance = _estimates(grid, columns, [fit.ratio for fit in fits])
    if at is not None:
        rows = np.searchsorted(grid, at)
        mean, variance = mean[rows], variance[rows]
    h = np.array([column.h for column in columns])
    noise_std = np.array([fit.noise_std for fit in fits])
    return Smoothed(
        x=mean[:, 0] + np.array([column.offset for column in columns]),
        rate=mean[:, 1] / h,
        acceleration=mean[:, 2] / h**2,
        std_x=noise_std * np.sqrt(variance[:, 0]),
        std_rate=noise_std * np.sqrt(variance[:, 1]) / h,
        noise_std=noise_std,
    )


def _check_times(t: np.ndarray, name: str) -> None:
    with np.errstate(invalid="ignore"):
        good = np.isfinite(t) & (np.diff(t, prepend=-np.inf) > 0)
    bad = np.flatnonzero(~good)
    if bad.size:
        raise InputError(
            f"{name}: time {bad[0] + 1} is {t[bad[0]]} s; give finite, strictly "
            "increasing times"
        )


def _column(t: np.ndarray, x: np.ndarray, label: str) -> Column:
    valid = ~np.isnan(x)
    t, x = t[valid], x[valid]
    if t.size < 4:
        raise InputError(f"{label} has {t.size} samples; smoothing needs at least 4")
    if np.isinf(x).any():
        raise InputError(f"{label} has infinite values; give finite samples or NaN")
    # Neither long gaps nor samples that all but coincide set the unit of time.
    h = float(np.quantile(np.diff(t), 0.9))
    return Column(t, x, h, offset=float(x.mean()))


def _stds(
    std: float | np.ndarray | None, columns: int, name: str
) -> Sequence[float | None]:
    if std is None:
        return [None] * columns
    values = np.broadcast_to(std, (columns,))
    if not (np.isfinite(values) & (values > 0)).all():
        raise InputError(f"{name}: std {std}; give positive numbers, or None")
    return [float(value) for value in values]


def _estimates(
    grid: np.ndarray, columns: Sequence[Column], ratio: Sequence[float]
) -> tuple[Float[np.ndarray, "n 3 columns"], Float[np.ndarray, "n 2 columns"]]:
    """Position, rate and acceleration, and variances, in units of noise and spacing."""
    mean = np.empty((grid.size, 3, len(columns)))
    variance = np.empty((grid.size, 2, len(columns)))
    for first in range(0, len(columns), LANES):
        lanes = np.minimum(np.arange(first, first + LANES), len(columns) - 1)
        group = slice(first, first + LANES)
        _estimate(
            grid,
            [columns[k] for k in lanes],
            np.array([ratio[k] for k in lanes]),
            mean[:, :, group],
            variance[:, :, group],
        )
    for k, column in enumerate(columns):
        outside = (grid < column.t[0]) | (grid > column.t[-1])
        mean[outside, :, k], variance[outside, :, k] = np.nan, np.nan
    return mean, variance


def _estimate(
    grid: np.ndarray,
    columns: Sequence[Column],
    ratio: np.ndarray,
    mean: np.ndarray,
    variance: np.ndarray,
) -> None:
    """One column a lane, written into `mean` and `variance`.

    What is known is kept only where a block starts, and each block's forward pass is
    done again on the way back: the factors of a long record need no memory.
    """
    known, starts = NOTHING_KNOWN, []
    for start in range(0, grid.size, BLOCK):
        starts.append((start, known))
        known, _ = forward(known, *_block(grid, columns, start), ratio)
    after = final_estimate(known)
    for start, known in reversed(starts):
        block = _block(grid, columns, start)
        _, rows = forward(known, *block, ratio)
        after, here = backward(after, block[0], rows, ratio)
        size, width = mean[start : start + BLOCK].shape[::2]
        mean[start : start + BLOCK] = here.mean[:size, :3, :width]
        for k in range(2):
            variance[start : start + BLOCK, k] = here.covariance[:size, k, k, :width]


def _block(
    grid: np.ndarray, columns: Sequence[Column], start: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """`dt`, `y` and `weight` of a block's steps, each `BLOCK LANES`."""
    dt, y, weight = np.zeros((3, BLOCK, LANES))
    here = grid[start : start + BLOCK]
    before = grid[max(start - 1, 0)]
    for k, column in enumerate(columns):
        # Time stands still for a column before its first and after its last sample.
        clipped = np.clip(np.append(before, here), column.t[0], column.t[-1])
        dt[: here.size, k] = np.diff(clipped) / column.h
        low = np.searchsorted(column.t, here[0])
        high = np.searchsorted(column.t, here[-1], side="right")
        rows = np.searchsorted(here, column.t[low:high])
        y[rows, k] = column.x[low:high] - column.offset
        weight[rows, k] = 1.0
    return dt, y, weight
