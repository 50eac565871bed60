"""The samples that a picture shows: extremes of every column of pixels."""

import numpy as np
from jaxtyping import Float, Int

COLUMNS = 600
"""Columns of pixels of a chart: as wide as two of them are on a page."""

GAP = 5.0
"""Times the usual distance of samples: no line is drawn across,"""

WIDE = 0.01
"""nor anywhere but where it is this part of the whole."""


def extremes(
    t: Float[np.ndarray, " n"], x: Float[np.ndarray, " n"], columns: int = COLUMNS
) -> Int[np.ndarray, " shown"]:
    """Which samples to draw: least and largest of each column, in order.

    Args:
        t: times, increasing.
        x: finite.
        columns: of pixels.
    """
    if t.size <= 2 * columns:
        return np.arange(t.size)
    span = t[-1] - t[0]
    column = np.minimum((t - t[0]) / span * columns, columns - 1).astype(int)
    starts = np.flatnonzero(np.diff(column, prepend=-1))
    counts = np.diff(starts, append=t.size)
    chosen = [
        _first_of_each(x == np.repeat(extreme.reduceat(x, starts), counts), column)
        for extreme in (np.minimum, np.maximum)
    ]
    return np.union1d(*chosen)


def _first_of_each(hit: np.ndarray, column: np.ndarray) -> Int[np.ndarray, " columns"]:
    hits = np.flatnonzero(hit)
    _, first = np.unique(column[hits], return_index=True)
    return hits[first]


def with_gaps(
    t: Float[np.ndarray, " n"], x: Float[np.ndarray, " n"]
) -> tuple[Float[np.ndarray, " m"], Float[np.ndarray, " m"]]:
    """The samples with a NaN wherever a sensor was silent for long."""
    dt = np.diff(t)
    if not dt.size:
        return t, x
    wide = max(GAP * float(np.median(dt)), WIDE * float(t[-1] - t[0]))
    after = np.flatnonzero(dt > wide) + 1
    return np.insert(t, after, t[after]), np.insert(x, after, np.nan)
