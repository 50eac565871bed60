"""The rows of the table: the union of all sensors' stamps."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Int

from orbident.recordings.topics.timing import SAME_TIME

Stamps = Int[np.ndarray, " _"]


def common_rows(stamps: Sequence[Stamps]) -> tuple[Stamps, list[Stamps]]:
    """Rows for stamps of several sensors; those within `SAME_TIME` share one.

    Args:
        stamps: ns, of each sensor, increasing by more than `SAME_TIME`.

    Returns:
        The rows' times, ns, increasing; and for each sensor which row each of its
        stamps is in, never two in one.
    """
    rows = np.empty(0, dtype=np.int64)
    chosen = []
    for each in stamps:
        chosen.append(_row_times(rows, each))
        rows = np.union1d(rows, chosen[-1])
    return rows, [np.searchsorted(rows, times) for times in chosen]


def _row_times(rows: Stamps, stamps: Stamps) -> Stamps:
    """The nearest row's time for each stamp if that is close enough, else its own."""
    if not rows.size:
        return stamps
    after = np.minimum(np.searchsorted(rows, stamps), rows.size - 1)
    before = np.maximum(after - 1, 0)
    is_before = np.abs(stamps - rows[before]) <= np.abs(rows[after] - stamps)
    nearest = np.where(is_before, rows[before], rows[after])
    close = np.flatnonzero(np.abs(nearest - stamps) <= SAME_TIME)
    # Two stamps of one sensor may be close to the same row: the first has it.
    free = np.diff(nearest[close], prepend=-1) != 0
    times = stamps.copy()
    times[close[free]] = nearest[close[free]]
    return times
