"""Which times of a stream to believe, whatever the clocks of its senders say.

Samples whose times follow each other are of one clock, and one clock is believed at a
time: as long as it goes on, what other clocks say is dropped. Another one takes over
once it has gone on alone, so that a wrong time, a second sender or a clock that is set
neither ends the run nor mixes what is true of two instants. Only differences of times
count, to the microsecond: the zero of time does not matter.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.live.rate_smoothing import HALF

PAUSE = HALF
"""s: a time that is further ahead is another clock's, or of after an interruption,
across which nothing can be smoothed."""

LATE = 10.0
"""s: networks delay packets by less; what is further behind is another clock's."""

ALONE = 1.0
"""s, for which another clock has to go on alone, so that two senders that send many
samples at once do not take over from each other in turn,"""

WARM_UP = 50
"""and for so many samples, which tell how far apart they are."""

RATE = 1000
"""Hz: what comes faster is averaged, since one processor can take in no more."""

CLOCKS = 8
"""That may wait to take over; more are no senders but times at random."""

DIGITS = 6
"""Of a time in seconds that count: what they tell is far below a sample's distance, and
a double holds them of any time since 1970."""

NEXT, AVERAGED, LATER = "next", "averaged", "late"
"""A sample that goes on where its clock's last one was, or as near to it as no two are
taken in, or that is not later."""

Row = Float[np.ndarray, " all"]
"""A sample, its time first."""


@dataclass(eq=False)
class StreamClock:
    """Times that follow each other, which count from the first one."""

    first: float
    """As it was sent, s."""
    newest: float = 0.0
    together: int = 1
    """Samples of which the last one is the average."""
    rows: list[Row] = field(default_factory=list)
    """Samples that wait for it to take over."""

    @property
    def ready(self) -> bool:
        """Whether it has gone on long enough."""
        return len(self.rows) >= WARM_UP and self.newest >= ALONE

    @property
    def step(self) -> float:
        """From sample to sample, s."""
        steps = np.diff([float(row[0]) for row in self.rows])
        return max(round(float(np.median(steps)), DIGITS), 1 / RATE)

    def since(self, t: float) -> float:
        """The time since the first one, s."""
        return round(t - self.first, DIGITS)

    def order(self, t: float) -> str:
        """What a sample sent at `t` is: `NEXT`, `AVERAGED`, `LATER` or another's."""
        since = self.since(t)
        if not -LATE <= round(since - self.newest, DIGITS) <= PAUSE:
            return ""
        if since <= self.newest:
            return LATER
        return AVERAGED if _slot(since) == _slot(self.newest) else NEXT

    def add(self, row: Row, together: int = 1) -> None:
        """Go on to a row, changed so that its time counts from the first one.

        It may be the average of several samples, which are together.
        """
        row[0] = self.newest = self.since(float(row[0]))
        self.together = together


def _slot(since: float) -> int:
    """Which multiple of 1 / RATE is nearest; halves are the earlier one's."""
    ticks, size = round(since * 10**DIGITS), 10**DIGITS // RATE
    return (ticks + size // 2 - 1) // size


class Heard(NamedTuple):
    """What a sample leads to. Times count from its clock's first one."""

    rows: Sequence[Row] = ()
    """Samples of the clock that is believed, to be taken in."""
    more: Row | None = None
    """One that is to be averaged into the last of them, as one of `together`."""
    crossed: StreamClock | None = None
    """This clock, if it has just taken over."""


@dataclass
class StreamClocks:
    """The clock that is believed, and others that wait to take over."""

    attitude: slice
    """Where a sample has its quaternion, whose sign is free."""
    believed: StreamClock | None = None
    others: list[StreamClock] = field(default_factory=list)
    """The one that was heard last is the last."""

    def waiting(self) -> int:
        """How many samples of other clocks wait."""
        return sum(len(each.rows) for each in self.others)

    def hear(self, row: Row, counts: Counter[str]) -> Heard:
        """Take the next sample in.

        The row, whose time is as it was sent, is changed, and so is `counts`: what
        became of samples that are not taken in.
        """
        t, orders = float(row[0]), {}
        for clock in (*filter(None, [self.believed]), *self.others):
            order = clock.order(t)
            if order == NEXT:
                return self._go_on(clock, row, counts)
            orders.setdefault(order, clock)
        orders.pop("", None)
        if orders:
            order, clock = next(iter(orders.items()))
            counts[order] += 1
            return self._average(clock, row) if order == AVERAGED else Heard()
        clock = StreamClock(t, rows=[row])
        clock.add(row)
        self.others.append(clock)
        if len(self.others) > CLOCKS:
            counts["foreign"] += len(self.others.pop(0).rows)
        return Heard()

    def averaged(self, last: Row, row: Row, together: int) -> Row:
        """The mean of so many samples, of which `last` is that of all but the row."""
        other = row.copy()
        if last[self.attitude] @ row[self.attitude] < 0:
            other[self.attitude] *= -1
        mean = last + (other - last) / together
        # Not every sample has a velocity.
        return np.where(np.isnan(mean), np.fmax(last, other), mean)

    def _average(self, clock: StreamClock, row: Row) -> Heard:
        clock.add(row, clock.together + 1)
        if clock is self.believed:
            return Heard(more=row)
        clock.rows[-1] = self.averaged(clock.rows[-1], row, clock.together)
        return Heard()

    def _go_on(self, clock: StreamClock, row: Row, counts: Counter[str]) -> Heard:
        clock.add(row)
        rows, crossed = [row], None
        if clock is not self.believed:
            clock.rows.append(row)
            self.others.remove(clock)
            if not clock.ready:
                self.others.append(clock)
                return Heard()
            rows, crossed = clock.rows, clock
            self.believed = replace(clock, rows=[])
        if self.others:
            counts["foreign"] += self.waiting()
            self.others = []
        return Heard(rows, None, crossed)
