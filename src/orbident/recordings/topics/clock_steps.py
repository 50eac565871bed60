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
"""Samples: so many in order come once out of some 8! = 40 320 that are shuffled."""
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
                f"{found + 1}, {at:.6g} s after the first, and goes on from there: the "
                "clock was set or began again; cut the file there, convert each part, "
                "and give all parts to 'identify'"
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
    steps = np.flatnonzero(np.diff(stamps) < 0) + 1
    latest = np.maximum.accumulate(stamps)
    for start, stop in zip(steps, np.append(steps, stamps.size)[1:], strict=True):
        late = stamps[start:stop]
        late = late[late < latest[start - 1]]
        if np.unique(late).size >= _RUN and not _fills(stamps, int(start), late, same):
            return int(start)
    return None


def _fills(
    stamps: Stamps,
    start: int,
    late: Stamps,
    same: Callable[[Stamps, Stamps], Bool[np.ndarray, " _"]],
) -> bool:
    """Whether most of what comes late is missing before it, or sent a second time."""
    order = np.argsort(stamps[:start], kind="stable")
    earlier = stamps[order]
    after = np.searchsorted(earlier, late)
    gap = earlier[after] - earlier[np.maximum(after - 1, 0)]
    fills = (after > 0) & (gap > 1.5 * _interval(stamps))
    again = earlier[after] == late
    repeated = np.flatnonzero(again)
    fills[again] = same(start + repeated, order[after[again]])
    return bool(np.mean(fills) >= 0.5)
