"""Samples in the order of their stamps, each stamp once."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int

from orbident.errors import InputError
from orbident.recordings.topics.track import RowFile, Stamps, Track

_RUN = 8
"""Samples: so many in order come by chance once among 8! = 40 320 in any order."""
_CLOSE = 0.6
"""Of the interval: in between samples, none is farther from one than half of it."""
_BITS = (16, 32)
"""Of the counters that are usual."""
_NEAR = 1e-3
"""Of a period: some samples may be lost where it ends, but a clock that was set by
chance so is one in a thousand."""
_BEGIN_AGAIN = (86_400 * 10**9, 604_800 * 10**9)
"""ns, of a time of day, and of a second of the week, as GPS has it."""
_LONGEST = 2**60
"""ns, 36 years: several of them are still no overflow."""
_COUNTS = (10**3, 10**6)
"""ns, of what a counter counts, whatever unit its times are in: us and ms."""


def continued(
    stamps: Stamps,
    counts: Iterable[int],
    same: Callable[[Stamps, Stamps], Bool[np.ndarray, " _"]],
    place: str,
) -> tuple[Stamps, str]:
    """The stamps as a counter without an end gives them, and what was done, in words.

    Stamps are in ns, in the order of arrival. `counts` are what a count of them may be,
    ns, and `same` says whether samples, by their numbers, hold the same values as
    others.

    Raises:
        InputError: the time goes back where no counter begins again.
    """
    periods = {2**bits * count for count in (*counts, *_COUNTS) for bits in _BITS}
    said = ""
    while (found := _step_back(stamps, same)) is not None:
        ahead = int(stamps[found - 1] - stamps[found])
        interval = _interval(stamps)
        fitting = [
            period
            for period in sorted(periods.union(_BEGIN_AGAIN))
            if _RUN * interval < period < _LONGEST
            and 0 < period - ahead <= max(3 * interval, _NEAR * period)
        ]
        if not fitting:
            at = (stamps[found - 1] - stamps[0]) / 1e9
            raise InputError(
                f"{place}: the time goes back by {ahead / 1e9:.6g} s at sample "
                f"{found + 1}, {at:.6g} s after the first, and goes on from there: its "
                "clock was set or began again, or two recordings were joined; cut the "
                "file there, convert each part, and give all parts to 'identify'"
            )
        steps = np.diff(stamps, prepend=stamps[0])
        turns = -np.rint(steps / fitting[0]).astype(np.int64)
        stamps = stamps + fitting[0] * np.cumsum(turns)
        said = f"its time begins again after {fitting[0] / 1e9:.10g} s, put right"
    return stamps, said


def _interval(stamps: Stamps) -> float:
    steps = np.diff(stamps)
    return float(np.median(steps[steps > 0]))


def _step_back(
    stamps: Stamps, same: Callable[[Stamps, Stamps], Bool[np.ndarray, " _"]]
) -> int | None:
    """The first sample of a run that goes back and fills no gap."""
    starts = np.flatnonzero(np.diff(stamps) < 0) + 1
    # More often than that nothing is in order, and only sorting helps.
    if not 0 < starts.size < stamps.size / 4:
        return None
    latest, earliest = np.maximum.accumulate(stamps), np.minimum.accumulate(stamps)
    distinct, first = np.unique(stamps, return_index=True)
    interval = _interval(stamps)
    for start, stop in zip(starts, np.append(starts, stamps.size)[1:], strict=True):
        late = stamps[start:stop]
        late = late[late < latest[start - 1]]
        if np.unique(late).size < _RUN:
            continue
        at = np.searchsorted(distinct, late)
        apart = np.minimum(distinct[at + 1] - late, late - distinct[at - 1])
        fills = apart > _CLOSE * interval
        # Before all others only a part of which the others are the continuation.
        ahead = earliest[start - 1] - late[-1]
        if not 0 < ahead <= 3 * interval:
            fills &= late >= earliest[start - 1]
        # Sent a second time: what differs then is no repetition.
        again = np.flatnonzero(first[at] < start)
        fills[again] = same(start + again, first[at[again]])
        if np.mean(fills) < 0.5:
            return int(start)
    return None


SAME_TIME = 100
"""ns; stamps this close are of one time: no sensor is faster, and drivers round."""

_BATCH_ROWS = 65_536


@dataclass(frozen=True, eq=False)
class Timed:
    """An entry's samples that are used."""

    track: Track
    stamps: Int[np.ndarray, " used"]
    """ns, increasing by more than `SAME_TIME`."""
    order: Int[np.ndarray, " used"]
    """Which row in the order of arrival."""
    clock: str
    """Which time the stamps are: "header", "receive", or "stamp" of a table."""
    rejected: dict[str, int]
    """Samples whose header's stamp is zero, or that another has too, and messages that
    could not be decoded, by reason."""
    duplicate_differs: int
    """How many of the duplicates are not the same as the one that is kept."""
    out_of_order: int
    """Samples that came after one with a later stamp; they are used."""
    note: str
    """What was done to a counter that began again."""
    ahead: float
    """s, how far the stamps are before the time of recording, the median."""


def timed(track: Track, file: str) -> Timed:
    """Sorts the samples of a track by stamp and keeps the first one of each.

    They have the stamps of their headers, unless the map says otherwise or none is set;
    then they have the time of recording. The file's name is for messages.

    Raises:
        InputError: as `Track.finished`, and where the time goes back where no counter
            begins again.
    """
    rows, entry = track.rows, track.entry
    place = f"{file}: topic '{entry.topic}'"
    sent, received = track.finished(place)
    is_set = sent > 0
    by_header = entry.time == "header" and bool(is_set.any())
    used = np.flatnonzero(is_set) if by_header else np.arange(received.size)
    stamps = (sent if by_header else received)[used] + round(entry.offset * 1e9)
    ahead = float(np.median(stamps - received[used])) / 1e9
    stamps, note = continued(
        stamps,
        entry.counts,
        lambda some, others: _same(rows, used[some], used[others]),
        place,
    )
    late = np.count_nonzero(np.maximum.accumulate(stamps) > stamps)
    order = np.argsort(stamps, kind="stable")
    stamps, order = stamps[order], used[order]
    first = np.diff(stamps, prepend=stamps[0] - SAME_TIME - 1) > SAME_TIME
    return Timed(
        track=track,
        stamps=stamps[first],
        order=order[first],
        clock=entry.sender_time if by_header else entry.other_time,
        rejected={
            "duplicate": int(np.count_nonzero(~first)),
            "without_stamp": sent.size - used.size,
            "undecodable": track.undecodable,
        },
        duplicate_differs=_differing(rows, order, first),
        out_of_order=int(late),
        note=note,
        ahead=ahead,
    )


def _differing(
    rows: RowFile, order: Int[np.ndarray, " n"], first: Bool[np.ndarray, " n"]
) -> int:
    """How many repeated samples differ from the one with their stamp that is kept."""
    repeated, leaders = np.flatnonzero(~first), np.flatnonzero(first)
    kept = leaders[np.searchsorted(leaders, repeated) - 1]
    batches = (
        slice(start, start + _BATCH_ROWS)
        for start in range(0, repeated.size, _BATCH_ROWS)
    )
    same = (_same(rows, order[repeated[k]], order[kept[k]]) for k in batches)
    return sum(int(np.count_nonzero(~each)) for each in same)


def _same(
    rows: RowFile, some: Int[np.ndarray, " n"], others: Int[np.ndarray, " n"]
) -> Bool[np.ndarray, " n"]:
    """Whether samples, by their numbers, have the same values as others."""
    a, b = rows.gather(some), rows.gather(others)
    return ((a == b) | (np.isnan(a) & np.isnan(b))).all(axis=1)


def common_rows(stamps: Sequence[Stamps]) -> tuple[Stamps, list[Stamps]]:
    """Rows for stamps of several sensors; those within `SAME_TIME` share one.

    Stamps of each sensor, ns, increase by more than `SAME_TIME`. Gives the rows' times,
    ns, increasing; and for each sensor which row each of its stamps is in, never two in
    one.
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
