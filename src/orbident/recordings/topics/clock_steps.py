"""Times that go back: counters that begin again, and clocks that are set.

A sample that came late fills a gap which it left. Where a whole run of samples goes
back to where no gap is, it is the clock that went back.
"""

from collections.abc import Callable, Iterable

import numpy as np
from jaxtyping import Bool, Int

from orbident.errors import InputError

Stamps = Int[np.ndarray, " _"]

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

    Args:
        stamps: ns, in the order of arrival.
        counts: ns, what a count of the stamps may be.
        same: whether samples, by their numbers, hold the same values as others.
        place: for messages.

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
