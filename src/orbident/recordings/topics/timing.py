"""Samples in the order of their stamps, each stamp once."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int

from orbident.errors import InputError
from orbident.recordings.topics.clock_steps import continued
from orbident.recordings.topics.row_file import RowFile
from orbident.recordings.topics.track import Arrived, Values

SAME_TIME = 100
"""ns; stamps this close are of one time: no sensor is faster, and drivers round."""

_BATCH_ROWS = 65_536


@dataclass(frozen=True, eq=False)
class Timed:
    """An entry's samples that are used."""

    values: Values
    stamps: Int[np.ndarray, " used"]
    """ns, increasing by more than `SAME_TIME`."""
    order: Int[np.ndarray, " used"]
    """Which row in the order of arrival."""
    clock: str
    """Which time the stamps are: "header", "receive", or "stamp" of a table."""
    without_stamp: int
    """Samples rejected because their header's stamp is zero."""
    duplicate: int
    """Samples rejected because another has the same stamp."""
    duplicate_differs: int
    """How many of the rejected are not the same as the one that is kept."""
    out_of_order: int
    """Samples that came after one with a later stamp; they are used."""
    note: str
    """What was done to a counter that began again."""


def timed(arrived: Arrived, place: str) -> Timed:
    """Sorts by stamp and keeps the first sample of each.

    Header stamps are used unless the map says otherwise or none is set; then it is
    the time of recording.

    Raises:
        InputError: the time goes back where no counter begins again.
    """
    rows, entry = arrived.values.rows, arrived.values.entry
    is_set = arrived.stamps > 0
    by_header = entry.time == "header" and bool(is_set.any())
    if by_header:
        used = np.flatnonzero(is_set)
        stamps = arrived.stamps[used]
    else:
        used = np.arange(arrived.received.size)
        stamps = arrived.received
    stamps, note = continued(
        stamps,
        entry.counts,
        lambda some, others: _same(rows, used[some], used[others]),
        f"{place}: topic '{entry.topic}'",
    )
    late = np.count_nonzero(np.maximum.accumulate(stamps) > stamps)
    order = np.argsort(stamps, kind="stable")
    stamps, order = stamps[order], used[order]
    first = np.diff(stamps, prepend=stamps[0] - SAME_TIME - 1) > SAME_TIME
    return Timed(
        values=arrived.values,
        stamps=stamps[first],
        order=order[first],
        clock="header" if by_header else entry.other_time,
        without_stamp=arrived.stamps.size - used.size,
        duplicate=int(np.count_nonzero(~first)),
        duplicate_differs=_differing(rows, order, first),
        out_of_order=int(late),
        note=note,
    )


def _differing(
    rows: RowFile, order: Int[np.ndarray, " n"], first: Bool[np.ndarray, " n"]
) -> int:
    """How many repeated samples differ from the one with their stamp that is kept."""
    count = 0
    for repeated, kept in _pairs(order, first):
        count += int(np.count_nonzero(~_same(rows, repeated, kept)))
    return count


def _same(
    rows: RowFile, some: Int[np.ndarray, " n"], others: Int[np.ndarray, " n"]
) -> Bool[np.ndarray, " n"]:
    """Whether samples, by their numbers, have the same values as others."""
    a, b = rows.gather(some), rows.gather(others)
    return ((a == b) | (np.isnan(a) & np.isnan(b))).all(axis=1)


def _pairs(
    order: Int[np.ndarray, " n"], first: Bool[np.ndarray, " n"]
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    repeated = np.flatnonzero(~first)
    leaders = np.flatnonzero(first)
    for start in range(0, repeated.size, _BATCH_ROWS):
        batch = repeated[start : start + _BATCH_ROWS]
        leader = leaders[np.searchsorted(leaders, batch) - 1]
        yield order[batch], order[leader]


def check_times(place: str, all_timed: list[Timed]) -> None:
    """Refuses what is no recording yet.

    Raises:
        InputError: Fewer than two stamps in all.
    """
    distinct = {int(s) for each in all_timed for s in each.stamps[:2]}
    if len(distinct) < 2:
        raise InputError(f"{place}: has a single sample; at least 2 are needed")
