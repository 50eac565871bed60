"""The recursive filter on samples as they come, whatever they are.

Every sample is judged by what came before it, and where that leaves two readings, by
the next ones: so estimates do not depend on how samples are grouped on their way. Nor
do they on the zero of time: times count from the first sample that is believed.

Over samples that follow each other runs one robot's filter, with its watch for changes.
"""

import hashlib
from collections import Counter
from collections.abc import Sequence
from copy import deepcopy
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from orbident import _core
from orbident.estimation.estimate import Change
from orbident.estimation.recursive.filter import (
    UNCERTAINTY,
    Extended,
    GaussianPrior,
    cad_covariance,
    cad_prior,
    factor_of,
)
from orbident.estimation.recursive.filter_input import declared_noise
from orbident.estimation.recursive.history import Detector
from orbident.identified.flight_export import robot_header
from orbident.live.rate_smoothing import HALF, ready, smoothed_at, still_needed
from orbident.live.sources import complete
from orbident.live.stream_clocks import DIGITS, RATE, Row, StreamClock, StreamClocks
from orbident.robot.description import Robot
from orbident.robot.joint_schema import require_measured

ONSET = 1.0
"""s: what comes on more slowly the filter follows. No fewer samples than a detector
has by default."""

PER_ALARM = 1_000_000
"""Samples in which a false alarm has the detector's probability."""

COUNTS = ("counted", "missing", "absurd", "late", "repeated")
"""What becomes of a sample, in the core's order; late is not later than the last."""


class Tools(NamedTuple):
    """What the filter of a robot and of a rate is made of."""

    dt: float
    """From sample to sample as they are sent, s: the gyro's noise depends on it."""
    kalman: Extended
    prior: GaussianPrior
    opening: Float[np.ndarray, "beta beta"]
    """Factor of what a change may do."""
    detector: Detector
    mark: str
    """A checksum of all that."""


def tools_of(robot: Robot, dt: float, velocity_std: float | None) -> Tools:
    """A filter that starts from the CAD values, 30 % uncertain.

    `dt` is from sample to sample as they are sent, s, and `velocity_std` that of a
    velocity sample, m/s; None where none is measured.

    Raises:
        InputError: the gyro's noise is not declared.
    """
    require_measured(robot, "the filter")
    kalman = Extended.of(robot, declared_noise(robot, dt, velocity_std))
    window = max(Detector.window, round(ONSET / max(dt, 1 / RATE)))
    detector = Detector(kalman.rows, window=window, samples=PER_ALARM)
    opening, prior = factor_of(cad_covariance(robot, UNCERTAINTY)), cad_prior(robot)
    mark = hashlib.sha256(robot_header(robot, kalman, detector).encode()).hexdigest()
    return Tools(dt, kalman, prior, opening, detector, mark)


class Running(NamedTuple):
    """A filter that has begun; a constant."""

    tools: Tools
    state: _core.FilterState
    watch: _core.Watch

    def opened(self, t: float | None = None) -> "Running":
        """After a change of the robot, or where the clock was set to `t`, s."""
        core, tools = self.tools.kalman.core, self.tools
        state = core.opened(self.state, tools.opening, t)
        return Running(tools, state, tools.detector.start())

    @property
    def std(self) -> Float[np.ndarray, " beta"]:
        """Deviations of the estimate."""
        return np.linalg.norm(np.linalg.inv(self.state.root), axis=1)


class Ran(NamedTuple):
    """Samples that went through the filter."""

    running: Running
    size: int
    change: Change | None
    """That the last one of them shows."""
    lost: bool
    """Whether the estimate ran out of range at the last one: no mass is negative."""
    counts: Counter[str]

    @property
    def alone(self) -> bool:
        """Whether the last sample alone shows a change."""
        return self.change is not None and self.change.onset == self.change.t


def ran_through(before: Running, samples: Float[np.ndarray, "n all"]) -> Ran:
    """Take samples in, until one shows a change or the estimate is lost."""
    tools, t = before.tools, np.ascontiguousarray(samples[:, 0])
    state, watch, size, onset, beta, std, tests = tools.kalman.core.run(
        before.state, before.watch, tools.detector.threshold, t, _packed(samples)
    )
    numbers = np.hstack([beta[:size], std[:size], tests[:size]])
    sound = np.isfinite(numbers).all(axis=1) & (beta[:size, 0] > 0)
    lost = not sound.all()
    if lost:
        size, onset = int((~sound).argmax()) + 1, None
    which = np.bincount(tests[:size, 3].astype(int))
    counts = Counter({COUNTS[k]: int(n) for k, n in enumerate(which) if n})
    change = None
    if onset is not None:
        now, g = float(t[size - 1]), float(tests[size - 1, 2])
        change = tools.detector.change(now, onset, g)
    return Ran(Running(tools, state, watch), size, change, lost, counts)


def _packed(samples: Float[np.ndarray, "n all"]) -> Float[np.ndarray, "n packed"]:
    """As the filter takes them: without their times, and with nothing that acted."""
    return np.hstack([samples[:, 1:], np.zeros((len(samples), 3))])


def begun(tools: Tools, row: Row) -> Running:
    """A filter that knows its prior alone; the sample tells how large momentum is."""
    first = _packed(row[None])[0]
    state = tools.kalman.core.start(tools.prior.beta, tools.prior.root, first, None)
    return Running(tools, state, tools.detector.start())


SPIKES = "spikes"
"""Samples that alone would have been a change."""

EDGES = "unsmoothed"
"""Samples within half a second of the start, or of an interruption."""

LARGEST = 1e6
"""SI: what is more the core does not believe either,"""

FARTHEST = 1e9
"""s: nor a longer time between two samples."""


class LiveEvent(NamedTuple):
    """Something to be told."""

    kind: str
    """`estimate`, `change`, `clock` or `restart`."""
    t: float
    """Time of the sample that it follows from, s."""
    of: dict[str, Any]


@dataclass
class Carried:
    """All that is carried from sample to sample.

    The times of `past` and `held`, and `begin`, `before` and `due`, count from `zero`.
    """

    past: Float[np.ndarray, "m all"]
    """Samples that went through, of the last half second,"""
    held: Float[np.ndarray, "n all"]
    """and those that wait for others."""
    clocks: StreamClocks
    running: Running | None = None
    zero: float = np.nan
    """Time of the first sample that was believed, s."""
    begin: float = np.nan
    """Time of the first sample since which there is no interruption, s."""
    before: float = np.nan
    """Time of the last sample, s."""
    due: float = np.nan
    """Time of the next estimate to be told, s."""
    counts: Counter[str] = field(default_factory=Counter)

    @property
    def waiting(self) -> int:
        """Samples that later ones will decide about."""
        return len(self.held) + self.clocks.waiting()

    @property
    def now(self) -> float:
        """The time of the last sample as it came, s."""
        return self.as_sent(self.before)

    def since(self, t: float) -> float:
        """The time from `zero` to a time as it was sent, s."""
        return round(t - self.zero, DIGITS)

    def as_sent(self, t: float) -> float:
        """A time in the clock of the samples, s."""
        return round(self.zero + t, DIGITS)


class LiveFilter:
    """Takes samples in, and tells what they say."""

    def __init__(
        self, robot: Robot, velocity_std: float | None, every: float, carried: Carried
    ) -> None:
        """Go on from what is carried.

        Estimates are `every` s of the samples' times apart. `velocity_std` is that of a
        velocity sample, m/s, or None where velocities are not used.
        """
        self.carried = carried
        self._robot, self._velocity_std, self._every = robot, velocity_std, every
        self._told: list[LiveEvent] = []

    def take(self, samples: Float[np.ndarray, "n all"]) -> list[LiveEvent]:
        """Take some samples in, each with its time before it: all, or none.

        Raises:
            InputError: the gyro's noise is not declared.
        """
        before, self._told = self.carried, []
        at = self.carried = replace(
            before,
            held=before.held.copy(),
            counts=Counter(before.counts),
            clocks=deepcopy(before.clocks),
        )
        try:
            self._take(at, samples)
        except BaseException:
            # Ctrl-C too: what is carried is always that of after whole calls.
            self.carried = before
            raise
        return self._told

    def _take(self, at: Carried, samples: Float[np.ndarray, "n all"]) -> None:
        if self._velocity_std is None:
            samples[:, -6:-3] = np.nan
        whole = samples[complete(samples)]
        possible = whole[~(np.abs(whole[:, 1:]) >= LARGEST).any(axis=1)]
        at.counts["missing"] += len(samples) - len(whole)
        at.counts["absurd"] += len(whole) - len(possible)
        rows: list[Row] = []
        for row in possible:
            heard = at.clocks.hear(row, at.counts)
            if heard.crossed is not None:
                self._pass(rows, last=True)
                self._cross(heard.crossed)
                rows = []
            rows += [self._timed(each) for each in heard.rows]
            if heard.more is not None:
                self._average(rows if rows else at.held, self._timed(heard.more))
        self._pass(rows)

    def _timed(self, row: Row) -> Row:
        """With its time from `zero` instead of from its clock's first sample."""
        at = self.carried
        assert at.clocks.believed is not None
        row[0] = round(float(row[0]) + at.since(at.clocks.believed.first), DIGITS)
        return row

    def _average(self, rows: list[Row] | np.ndarray, row: Row) -> None:
        clocks = self.carried.clocks
        assert clocks.believed is not None
        rows[-1] = clocks.averaged(rows[-1], row, clocks.believed.together)

    def estimate(self) -> LiveEvent | None:
        """What is known now; None before the first sample."""
        at, running = self.carried, self.carried.running
        if running is None:
            return None
        state, core = running.state, running.tools.kalman.core
        values = {
            "beta": state.beta.tolist(),
            "std": running.std.tolist(),
            "scale": core.scaled(state, self._robot.mass),
            "counts": dict(at.counts),
        }
        return LiveEvent("estimate", at.now, values)

    def _pass(self, rows: Sequence[Row], last: bool = False) -> None:
        """Let those that wait, and these rows, pass as far as they are ready.

        They are the last if none that could tell more follows them.
        """
        at, first = self.carried, len(self.carried.past)
        if at.running is None:
            return
        if rows:
            at.held = np.vstack([at.held, *rows])
        samples = np.vstack([at.past, at.held])
        t = samples[:, 0]
        behind = max(first, ready(t))
        smooth = samples.copy()
        smooth[first:behind, -3:] = smoothed_at(t, samples[:, -3:], first, behind)
        taken = int(np.searchsorted(t[first:behind], at.begin + HALF))
        at.counts[EDGES] += taken
        if first + taken < behind:
            taken += self._run(at.running, smooth[first + taken : behind], last)
        at.held = at.held[taken:]
        at.past = samples[still_needed(t[: first + taken]) : first + taken]

    def _cross(self, clock: StreamClock) -> None:
        """Believe another clock."""
        at = self.carried
        # Samples before it that have too few others behind them.
        at.counts[EDGES] += len(at.held)
        at.past, at.held = at.past[:0], at.held[:0]
        if at.running is None:
            at.zero, at.before = clock.first, 0.0
            tools = tools_of(self._robot, clock.step, self._velocity_std)
            at.running = begun(tools, clock.rows[0])
        now = at.since(clock.first)
        if not 0 <= now - at.before <= FARTHEST:
            self._told.append(LiveEvent("clock", clock.first, {"before": at.now}))
            at.running = at.running.opened(now)
        at.begin = at.before = now
        at.due = now + self._every

    def _run(
        self, running: Running, samples: Float[np.ndarray, "n all"], last: bool
    ) -> int:
        """Take samples in, in the order in which they came; returns how many."""
        at, done = self.carried, 0
        while done < len(samples):
            rest = samples[done:]
            due = np.flatnonzero(rest[:, 0] >= at.due)
            ran = ran_through(
                running, rest[: int(due[0]) + 1 if due.size else len(rest)]
            )
            done += ran.size
            if ran.alone and not last:
                # The next sample decides between a change and a spike.
                without = ran_through(running, rest[: ran.size - 1])
                following = rest[ran.size : ran.size + 1]
                if not len(following):
                    self._accept(without)
                    return done - 1
                if not ran_through(without.running, following).change:
                    ran = without
                    at.counts[SPIKES] += 1
            self._accept(ran)
            running = self._followed(ran, samples[done - 1])
        return done

    def _accept(self, ran: Ran) -> None:
        self.carried.running = ran.running
        self.carried.counts.update(ran.counts)

    def _followed(self, ran: Ran, row: Float[np.ndarray, " all"]) -> Running:
        """The filter after what the last sample of a run leads to."""
        at, t, running = self.carried, float(row[0]), ran.running
        at.before = t
        if ran.change:
            change = ran.change._replace(t=at.now, onset=at.as_sent(ran.change.onset))
            self._told.append(LiveEvent("change", at.now, change._asdict()))
            running = running.opened()
        elif ran.lost:
            self._told.append(LiveEvent("restart", at.now, {}))
            running = begun(running.tools, row)
        at.running = running
        if t >= at.due:
            at.due = t + self._every - (t - at.due) % self._every
            told = self.estimate()
            assert told is not None
            self._told.append(told)
        return running
