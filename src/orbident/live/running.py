"""One robot's filter and its watch for changes, over samples that follow each other."""

import hashlib
from collections import Counter
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident import _core
from orbident.estimation.recursion import Change
from orbident.estimation.recursive.changes import Detector
from orbident.estimation.recursive.filter import Extended
from orbident.estimation.recursive.given import declared_noise
from orbident.estimation.recursive.prior import (
    UNCERTAINTY,
    GaussianPrior,
    cad_covariance,
    cad_prior,
    factor_of,
)
from orbident.identified.flight_export import robot_header
from orbident.live.stream_clocks import RATE, Row
from orbident.robot.description import Robot

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

    Args:
        robot: with the noise of its gyro.
        dt: from sample to sample as they are sent, s.
        velocity_std: of a velocity sample, m/s; None where none is measured.

    Raises:
        InputError: the gyro's noise is not declared.
    """
    kalman = Extended.of(robot, declared_noise(robot, dt, velocity_std))
    window = max(Detector.window, round(ONSET / max(dt, 1 / RATE)))
    detector = Detector(kalman.rows, window=window, samples=PER_ALARM)
    opening, prior = factor_of(cad_covariance(robot, UNCERTAINTY)), cad_prior(robot)
    table = robot_header(robot, kalman, prior, opening, detector)
    mark = hashlib.sha256(table.encode()).hexdigest()
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
        before.state,
        before.watch,
        tools.detector.threshold,
        t,
        _packed(samples),
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
