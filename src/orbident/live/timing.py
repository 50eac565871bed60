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
"""Hz: a second of so many samples smooths the gyro's noise below what else is wrong
with a rate, and one processor can take them in."""

CLOCKS = 8
"""That may wait to take over; more are no senders but times at random."""

DIGITS = 6
"""Of a time in seconds that count: what they tell is far below a sample's distance, and
a double holds them of any time since 1970."""

NEXT = "next"
"""A sample that goes on where its clock's last one was."""

Row = Float[np.ndarray, " all"]
"""A sample, its time first."""


@dataclass(eq=False)
class StreamClock:
    """Times that follow each other."""

    first: float
    newest: float
    rows: list[Row] = field(default_factory=list)
    """Samples that wait for it to take over,"""
    thinned: int = 0
    """and how many beside them were too many."""

    @property
    def ready(self) -> bool:
        """Whether it has gone on long enough."""
        return len(self.rows) >= WARM_UP and self.newest - self.first >= ALONE

    @property
    def step(self) -> float:
        """From sample to sample as they are sent, s."""
        t = np.array([float(row[0]) for row in self.rows])
        steps = np.diff(np.round(t - self.first, DIGITS))
        sent = len(self.rows) + self.thinned
        step = round(float(np.median(steps)) * len(self.rows) / sent, DIGITS)
        return max(step, 10**-DIGITS)

    def place(self, t: float) -> str:
        """What a sample of time `t` is: the next one, `late`, `thinned` or none."""
        ahead = round(t - self.newest, DIGITS)
        if not -LATE <= ahead <= PAUSE:
            return ""
        if ahead <= 0:
            return "late"
        same = self._slot(t) == self._slot(self.newest)
        return "thinned" if same else NEXT

    def _slot(self, t: float) -> int:
        """Of which one sample is taken in: what is nearest to a multiple of 1 / RATE.

        Halves are the earlier one's, so that slots of 10 kHz are all alike.
        """
        ticks, size = round((t - self.first) * 10**DIGITS), 10**DIGITS // RATE
        return (ticks + size // 2 - 1) // size


class Heard(NamedTuple):
    """What a sample leads to."""

    rows: Sequence[Row] = ()
    """Samples of the clock that is believed, to be taken in."""
    crossed: StreamClock | None = None
    """This clock, if it has just taken over."""


@dataclass
class StreamClocks:
    """The clock that is believed, and others that wait to take over."""

    believed: StreamClock | None = None
    others: list[StreamClock] = field(default_factory=list)
    """The one that was heard last is the last."""

    def copied(self) -> "StreamClocks":
        """One that can be changed without this one."""
        others = [replace(each, rows=list(each.rows)) for each in self.others]
        return StreamClocks(self.believed and replace(self.believed), others)

    def waiting(self) -> int:
        """How many samples of other clocks wait."""
        return sum(len(each.rows) for each in self.others)

    def hear(self, row: Row, counts: Counter[str]) -> Heard:
        """Take the next sample in.

        Args:
            row: the sample; its time is a number.
            counts: what became of samples that are dropped; it is changed.
        """
        t = float(row[0])
        places = {}
        for clock in (*filter(None, [self.believed]), *self.others):
            place = clock.place(t)
            if place == NEXT:
                return self._go_on(clock, t, row, counts)
            places[place] = clock
        places.pop("", None)
        if places:
            place, clock = next(iter(places.items()))
            counts[place] += 1
            clock.thinned += place == "thinned"
            return Heard()
        self.others.append(StreamClock(t, t, [row]))
        if len(self.others) > CLOCKS:
            counts["foreign"] += len(self.others.pop(0).rows)
        return Heard()

    def _go_on(
        self, clock: StreamClock, t: float, row: Row, counts: Counter[str]
    ) -> Heard:
        clock.newest = t
        rows, crossed = [row], None
        if clock is not self.believed:
            clock.rows.append(row)
            self.others.remove(clock)
            if not clock.ready:
                self.others.append(clock)
                return Heard()
            rows, crossed = clock.rows, clock
            self.believed = StreamClock(clock.first, t)
        if self.others:
            counts["foreign"] += self.waiting()
            self.others = []
        return Heard(rows, crossed)
