"""The recursive filter on samples as they come, whatever they are.

Every sample is judged by what came before it, and where that leaves two readings, by
the next one: so estimates do not depend on how samples are grouped on their way.
"""

import hashlib
from collections import Counter
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from orbident import _core
from orbident.estimation.recursion import Change
from orbident.estimation.recursive.changes import Detector
from orbident.estimation.recursive.filter import Extended
from orbident.estimation.recursive.noise import declared_noise
from orbident.estimation.recursive.prior import (
    UNCERTAINTY,
    GaussianPrior,
    cad_covariance,
    cad_prior,
    factor_of,
)
from orbident.identified.flight_tables import robot_header
from orbident.live.rate_smoothing import HALF, ready, smoothed_at, still_needed
from orbident.live.timing import Leap, next_run
from orbident.robot.description import Robot

WARM_UP = 50
"""Samples that tell how far apart they are, which the gyro's noise depends on."""

ONSET = 1.0
"""s: what comes on more slowly the filter follows. No fewer samples than a detector
has by default."""

PER_ALARM = 1_000_000
"""Samples in which a false alarm has the detector's probability."""

COUNTS = ("counted", "missing", "absurd", "late", "repeated")
"""What becomes of a sample, in the core's order; late is not later than the last."""

SPIKES = "spikes"
"""Samples that alone would have been a change."""

EDGES = "unsmoothed"
"""Samples within half a second of the start, or of an interruption."""


class Tools(NamedTuple):
    """What the filter of a robot and of a rate is made of."""

    dt: float
    """From sample to sample, s."""
    kalman: Extended
    prior: GaussianPrior
    opening: Float[np.ndarray, "beta beta"]
    """Factor of what a change may do."""
    detector: Detector
    mark: str
    """A checksum of all that."""


def tools_of(robot: Robot, dt: float, velocity_std: float | None) -> Tools:
    """A filter that starts from the CAD values, 30 % uncertain.

    Args:
        robot: with the noise of its gyro.
        dt: from sample to sample, s.
        velocity_std: of a velocity sample, m/s; None where none is measured.

    Raises:
        InputError: the gyro's noise is not declared.
    """
    kalman = Extended.of(robot, declared_noise(robot, dt, velocity_std))
    window = max(Detector.window, round(ONSET / dt))
    detector = Detector(kalman.rows, window=window, samples=PER_ALARM)
    opening, prior = factor_of(cad_covariance(robot, UNCERTAINTY)), cad_prior(robot)
    table = robot_header(robot, kalman, prior, opening, detector)
    mark = hashlib.sha256(table.encode()).hexdigest()
    return Tools(dt, kalman, prior, opening, detector, mark)


class Event(NamedTuple):
    """Something to be told."""

    kind: str
    """`estimate`, `change`, `clock` or `restart`."""
    t: float
    """Time of the sample that it follows from, s."""
    of: dict[str, Any]


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


@dataclass
class Carried:
    """All that is carried from sample to sample."""

    past: Float[np.ndarray, "m all"]
    """Samples that went through, of the last half second,"""
    held: Float[np.ndarray, "n all"]
    """and those that wait for others."""
    running: Running | None = None
    begin: float = np.nan
    """Time of the first sample since which there is no interruption, s."""
    before: float = np.nan
    """Time of the last sample, s."""
    due: float = np.nan
    """Time of the next estimate to be told, s."""
    counts: Counter[str] = field(default_factory=Counter)


class LiveFilter:
    """Takes samples in, and tells what they say."""

    def __init__(
        self, robot: Robot, velocity_std: float | None, every: float, carried: Carried
    ) -> None:
        """Go on from what is carried.

        Args:
            robot: whose samples come.
            velocity_std: of a velocity sample, m/s; None where none counts.
            every: time of the samples between two estimates that are told, s.
            carried: from before; it is changed.
        """
        self.carried = carried
        self._robot, self._velocity_std, self._every = robot, velocity_std, every
        self._told: list[Event] = []

    def take(self, samples: Float[np.ndarray, "n all"]) -> list[Event]:
        """Take some samples in, each with its time before it.

        Raises:
            InputError: the gyro's noise is not declared.
        """
        at, self._told = self.carried, []
        timed = ~np.isnan(samples[:, 0])
        at.counts["missing"] += int((~timed).sum())
        if self._velocity_std is None:
            samples[:, -6:-3] = np.nan
        at.held = np.vstack([at.held, samples[timed]])
        if at.running is None:
            at.running = self._begun()
        while at.running and len(at.held):
            size, leap = next_run(at.before, at.held[:, 0])
            if leap is Leap.alone:
                at.counts["absurd"] += 1
                at.held = np.delete(at.held, size, axis=0)
                continue
            crossed = leap in {Leap.forward, Leap.back}
            taken = self._pass(at.running, size, last=crossed)
            if not crossed:
                break
            self._cross(size - taken, back=leap is Leap.back)
        return self._told

    def estimate(self) -> Event | None:
        """What is known now; None before the first sample."""
        running = self.carried.running
        if running is None:
            return None
        state, core = running.state, running.tools.kalman.core
        values = {
            "beta": state.beta.tolist(),
            "std": np.linalg.norm(np.linalg.inv(state.root), axis=1).tolist(),
            "scale": core.scaled(state, self._robot.mass),
            "counts": dict(self.carried.counts),
        }
        return Event("estimate", state.t, values)

    def _begun(self) -> Running | None:
        """The filter, once enough samples have come to know their rate."""
        at = self.carried
        steps = np.diff(at.held[:WARM_UP, 0])
        steps = steps[steps > 0]
        if len(at.held) < WARM_UP or not steps.size:
            return None
        tools = tools_of(self._robot, float(np.median(steps)), self._velocity_std)
        for row in at.held:
            if running := _started(tools, row):
                at.begin = at.before = float(row[0])
                at.due = at.before + self._every
                return running
        return None

    def _pass(self, running: Running, size: int, last: bool) -> int:
        """Let those of the first samples pass that are ready; returns how many.

        Args:
            running: the filter before.
            size: of samples whose times follow each other.
            last: whether none that could tell more follows them.
        """
        at, first = self.carried, len(self.carried.past)
        rows = np.vstack([at.past, at.held[:size]])
        t = rows[:, 0]
        behind = max(first, ready(t))
        smooth = rows.copy()
        smooth[first:behind, -3:] = smoothed_at(t, rows[:, -3:], first, behind)
        trusted = t[first:behind] >= at.begin + HALF
        taken = int(trusted.argmax()) if trusted.any() else behind - first
        at.counts[EDGES] += taken
        if first + taken < behind:
            taken += self._run(running, smooth[first + taken : behind], last)
        at.held = at.held[taken:]
        at.past = rows[still_needed(t[: first + taken]) : first + taken]
        return taken

    def _cross(self, unready: int, back: bool) -> None:
        """Believe the time of a sample that is far from the one before.

        Args:
            unready: samples before it that have too few others behind them.
            back: whether the clock was set back.
        """
        at = self.carried
        at.counts[EDGES] += unready
        at.past, at.held = at.past[:0], at.held[unready:]
        t = float(at.held[0, 0])
        if back and at.running:
            self._told.append(Event("clock", t, {"before": at.before}))
            at.running = at.running.opened(t)
        at.begin = at.before = t
        at.due = t + self._every

    def _run(
        self, running: Running, samples: Float[np.ndarray, "n all"], last: bool
    ) -> int:
        """Take samples in whose times follow each other; returns how many.

        Args:
            running: the filter before.
            samples: in the order in which they came.
            last: whether none that could tell more follows them.
        """
        at, done = self.carried, 0
        while done < len(samples):
            rest = samples[done:]
            due = np.flatnonzero(rest[:, 0] >= at.due)
            ran = _ran(running, rest[: int(due[0]) + 1 if due.size else len(rest)])
            done += ran.size
            if ran.alone and not last:
                # The next sample decides between a change and a spike.
                without = _ran(running, rest[: ran.size - 1])
                following = rest[ran.size : ran.size + 1]
                if not len(following):
                    self._accept(without)
                    return done - 1
                if not _ran(without.running, following).change:
                    ran = without
                    at.counts[SPIKES] += 1
            self._accept(ran)
            running = self._followed(ran, samples[done - 1])
            at.running = running
        return done

    def _accept(self, ran: "Ran") -> None:
        self.carried.running = ran.running
        self.carried.counts.update(ran.counts)

    def _followed(self, ran: "Ran", row: Float[np.ndarray, " all"]) -> Running:
        """The filter after what the last sample of a run leads to."""
        at, t, running = self.carried, float(row[0]), ran.running
        at.before = t
        if ran.change:
            self._told.append(Event("change", t, ran.change._asdict()))
            running = running.opened()
        elif ran.lost:
            self._told.append(Event("restart", t, {}))
            running = _started(running.tools, row) or running
        at.running = running
        if t >= at.due:
            at.due += self._every * (1 + np.floor((t - at.due) / self._every))
            told = self.estimate()
            assert told is not None
            self._told.append(told)
        return running


class Ran(NamedTuple):
    """Samples that went through the filter."""

    running: Running
    size: int
    change: Change | None
    """That the last one of them shows."""
    lost: bool
    """Whether the estimate ran out of range at the last one."""
    counts: Counter[str]

    @property
    def alone(self) -> bool:
        """Whether the last sample alone shows a change."""
        return self.change is not None and self.change.onset == self.change.t


def _ran(before: Running, samples: Float[np.ndarray, "n all"]) -> Ran:
    """Take samples in, until one shows a change or the estimate is lost."""
    tools, t = before.tools, np.ascontiguousarray(samples[:, 0])
    state, watch, size, onset, beta, std, tests = tools.kalman.core.run(
        before.state,
        before.watch,
        tools.detector.threshold,
        t,
        _packed(samples),
    )
    sound = np.isfinite(beta[:size]).all(axis=1) & np.isfinite(std[:size]).all(axis=1)
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


def _started(tools: Tools, row: Float[np.ndarray, " all"]) -> Running | None:
    """A filter that begins at this sample, if it counts."""
    first = _packed(row[None])[0]
    state = tools.kalman.core.start(tools.prior.beta, tools.prior.root, first, None)
    running = Running(tools, state, tools.detector.start())
    return running if _ran(running, row[None]).counts["counted"] else None
