"""How rough a column is, and how noisy: the most likely density of its snap."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.signals.white_snap import BLOCK, LANES, NOTHING_KNOWN, ORDER, forward

STRETCHES = 4
"""Of `BLOCK` samples each, evenly spread: what is searched of a longer record."""

AVERAGED = 8
"""Samples that are averaged where motion is slow."""

SLOW = 64.0
"""Samples that smoothing reaches over. Beyond, a stretch of `BLOCK` is too short to
show how rough the motion is; and `AVERAGED` of them are as good as one."""

LARGEST = 1e12
"""Of the ratio. The spline then misses no sample by more than some millionths of what
that differs from its prediction; beyond, rounding takes over."""


SMALLEST = 1e-100
"""Of any unit: what a column of zeros is known to."""


class Column(NamedTuple):
    """The valid samples of one column; at least 4."""

    t: Float[np.ndarray, " n"]
    """s."""
    x: Float[np.ndarray, " n"]
    h: float
    """The unit of time, s: what 9 of 10 samples follow each other in."""
    offset: float
    """The mean: it says nothing of the motion, but would cost digits."""


class Fit(NamedTuple):
    """What a column is made of."""

    ratio: float
    """`q h^7 / noise_std^2`, `q` the two-sided spectral density of the snap."""
    noise_std: float
    """Of the samples, in the unit of the column; NaN where only 4 tell nothing."""


class _Evidence(NamedTuple):
    misfit: Float[np.ndarray, " lanes"]
    log_det: Float[np.ndarray, " lanes"]


def most_likely(column: Column, std: float | None) -> Fit:
    """The density of the snap under which the samples are most likely.

    `-2 log L = misfit / R + log_det + freedom log R`, `R = std^2`, is least, with the
    state at the start integrated out. Where `std` is None, `R = misfit / freedom`.
    Searched on a grid from "a cubic" to "through every sample", then on two finer ones;
    of more than 4096 samples, 4 stretches of 1024 stand for all, of averages where
    samples follow each other fast.

    Args:
        column: samples, any unit.
        std: of the measurement noise, in the unit of the column; None if unknown.
    """
    fit = _searched(column, std)
    reach = fit.ratio ** (-1 / (2 * ORDER))
    if column.t.size <= STRETCHES * BLOCK or reach < SLOW:
        return fit
    slow = most_likely(_averaged(column), fit.noise_std / np.sqrt(AVERAGED))
    return Fit(slow.ratio / float(AVERAGED) ** (2 * ORDER), fit.noise_std)


def _averaged(column: Column) -> Column:
    """Averages of neighbours, but for those across a gap."""
    n = column.t.size // AVERAGED * AVERAGED
    t, x = (each[:n].reshape(-1, AVERAGED) for each in (column.t, column.x))
    h = AVERAGED * column.h
    close = np.ptp(t, axis=1) < 2 * h
    return Column(t[close].mean(axis=1), x[close].mean(axis=1), h, column.offset)


def _searched(column: Column, std: float | None) -> Fit:
    """On the samples as they are."""
    stretches = _stretches(column)
    freedom = sum(t.size - ORDER for t, _ in stretches)
    # Samples are no better than their last bit, even of a joint that stands still.
    bit = np.finfo(np.float64).eps * max(np.abs(column.x).max(), SMALLEST)
    longest = max(t[-1] - t[0] for t, _ in stretches)
    span = (-2 * ORDER * np.log10(4 * longest), np.log10(LARGEST))

    def tried(low: float, high: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        grid = np.linspace(low, high, LANES)
        misfit, log_det = _evidence(stretches, 10**grid)
        R = np.maximum(misfit / max(freedom, 1), bit**2)
        if std is not None:
            R[:] = std**2
        return grid, R, misfit / R + log_det + freedom * np.log(R)

    for _ in range(2):
        grid, _, cost = tried(*span)
        step, best = grid[1] - grid[0], grid[np.argmin(cost)]
        span = (max(span[0], best - step), min(span[1], best + step))
    grid, R, cost = tried(*span)
    ratio = _vertex(grid, cost)
    if std is None:
        found = np.exp(np.interp(ratio, grid, np.log(R)) / 2) if freedom else np.nan
        return Fit(10**ratio, float(found))
    return Fit(10**ratio, std)


def _vertex(x: np.ndarray, y: np.ndarray) -> float:
    """Of the parabola through the least `y` and its neighbours; `x` is even."""
    k = int(np.argmin(y))
    if k in {0, x.size - 1}:
        return float(x[k])
    slope, bend = (y[k + 1] - y[k - 1]) / 2, y[k + 1] - 2 * y[k] + y[k - 1]
    return float(x[k] - (x[1] - x[0]) * slope / bend) if bend > 0 else float(x[k])


def _stretches(column: Column) -> list[tuple[np.ndarray, np.ndarray]]:
    t, x = column.t / column.h, column.x - column.offset
    if t.size <= STRETCHES * BLOCK:
        return [(t, x)]
    starts = np.linspace(0, t.size - BLOCK, STRETCHES).astype(int)
    return [(t[k : k + BLOCK], x[k : k + BLOCK]) for k in starts]


def _evidence(
    stretches: list[tuple[np.ndarray, np.ndarray]], ratio: np.ndarray
) -> _Evidence:
    misfit, log_det = np.zeros((2, LANES))
    for t, x in stretches:
        known, dt = NOTHING_KNOWN, np.diff(t, prepend=t[0])
        for start in range(0, t.size, BLOCK):
            parts = (each[start : start + BLOCK] for each in (dt, x, np.ones(t.size)))
            known, _ = forward(known, *map(_in_every_lane, parts), ratio)
        triangle = np.abs(np.diagonal(np.asarray(known.R)))
        misfit += np.asarray(known.misfit)
        log_det += 2 * (np.asarray(known.log_det) + np.log(triangle).sum(axis=1))
    return _Evidence(misfit, log_det)


def _in_every_lane(values: np.ndarray) -> np.ndarray:
    """Filled up to a block with zeros: there, time stands still."""
    padded = np.zeros(BLOCK)
    padded[: values.size] = values
    return np.repeat(padded[:, None], LANES, axis=1)
