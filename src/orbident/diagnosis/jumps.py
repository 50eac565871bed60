"""Sensors that jump from one sample to the next, as no smooth motion does.

A polynomial and a step at its middle are fitted to the samples around every one. The
step is a fixed filter of them, and where it stands far out of all that it gives over
the recording, the sensor jumped. If all sensors jump at once, time did. Rates leap with
the motion, so a gyro's jumps are looked for in what is left of it after the fit.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np
from jaxtyping import Float
from scipy.signal import argrelmax
from scipy.special import chdtri

from orbident.diagnosis.shifts import axes_of, shifted, shown_by
from orbident.diagnosis.suspects import Numbers, Scores, Suspect, tried
from orbident.diagnosis.trial import Trial
from orbident.estimation.estimate import Estimate
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.unknowns import Score
from orbident.files.names import joined

HALF, DEGREE = 10, 4
"""Samples before and after, and of the polynomial through them."""

FAR = 8.0
"""Deviations of the filter's own scatter."""

MOST = 4
"""Jumps of one sensor that are put right: more of them are noise."""

TOGETHER = 0.5
"""Part of the joints and sensors that jump at once where time does."""

RATES = ("gyro", "velocity")
OF_THE_BASE = ("position", "attitude", *RATES)


@dataclass(frozen=True)
class Jump:
    """A jump of one column or vector of the recording."""

    sensor: str
    """As columns of the recording begin."""
    row: int
    """The first after it."""
    times: float
    """Over the filter's scatter."""
    size: Float[np.ndarray, " axes"]
    """SI; of an attitude by its quaternion's components."""
    rate: Float[np.ndarray, " axes"]
    """The change of the shown rate at the jump, SI per second."""


def jumping(problem: MomentumProblem, sensor: str, rows: Sequence[int]) -> Suspect:
    """The suspect that a sensor is off by a constant from each of these rows on."""
    t, axes = problem.recording.t, axes_of(problem, sensor)
    joint = sensor.partition(".")[2]
    rows = sorted(rows)
    at = joined([f"{t[row]:.4g}" for row in rows])

    def words(c: Numbers) -> str:
        size = float(np.linalg.norm(c.reshape(len(rows), -1), axis=1).max())
        jump = f"a jump (a step) of {size:.2g} (SI) at t = {at} s"
        if len(rows) > 1:
            jump = f"jumps (steps) of up to {size:.2g} (SI) at t = {at} s"
        if joint:
            return f"joint {joint} slips: its position has {jump}"
        return f"the {sensor} has {jump}"

    later = np.arange(t.size)[:, None] >= np.array(rows)
    return shifted(sensor, later.astype(float), axes, words)


def jumps(problem: MomentumProblem, shown: Estimate, before: float) -> Iterator[Trial]:
    """Tried: the sensor, or the time, put right from then on."""
    by_sensor = shown_by(problem.robot, problem.recording)
    every = (
        jumps_of(sensor, problem.recording.t, x) for sensor, x in by_sensor.items()
    )
    found = sorted(chain(*every), key=lambda jump: -jump.times)
    at_once = [jump for jump in found if abs(jump.row - found[0].row) <= 1]
    if len(at_once) > max(1.0, TOGETHER * len(by_sensor)):
        yield from _lost_rows(problem, at_once)
        return
    # A rate may leap because the motion does.
    slow = [jump for jump in found if jump.sensor not in RATES]
    if slow and shown.solution is not None:
        sensor = slow[0].sensor
        rows = [jump.row for jump in slow if jump.sensor == sensor]
        suspect = jumping(problem, sensor, rows[:MOST])
        first = Scores(problem, shown.solution).of(suspect)
        if first.values.size:
            trials = tried(problem, suspect, first, before)
            yield from (one._replace(seen=True) for one in trials)


def steps(problem: MomentumProblem, shown: Estimate) -> Iterator[Suspect]:
    """Smaller ones of the base's sensors, in what is left of its motion."""
    for signal in shown.signals:
        if signal.name in OF_THE_BASE:
            left = signal.measured - signal.predicted
            found = jumps_of(signal.name, signal.t, left)[:MOST]
            at = signal.t[[jump.row for jump in found]]
            if found:
                rows = np.searchsorted(problem.recording.t, at)
                yield jumping(problem, signal.name, [*map(int, rows)])


def _lost_rows(problem: MomentumProblem, at_once: list[Jump]) -> Iterator[Trial]:
    """What all sensors jumped by is their rate by the time that is missing."""
    size = np.concatenate([jump.size * jump.times / _norm(jump) for jump in at_once])
    rate = np.concatenate([jump.rate * jump.times / _norm(jump) for jump in at_once])
    lost = float(size @ rate / max(rate @ rate, 1e-300))
    row = at_once[0].row
    at = f"at t = {problem.recording.t[row]:.4g} s"

    def words(c: Numbers) -> str:
        return (
            f"all sensors jump {at}: rows are missing (a gap) there, or the clock was "
            f"set, and {c[0]:.3g} s of time are lost"
        )

    def corrected(problem: MomentumProblem, c: Numbers) -> MomentumProblem:
        recording = problem.recording
        later = np.arange(recording.t.size) >= row
        return problem.amended(recording=replace(recording, t=recording.t + c * later))

    suspect = Suspect(words, np.array([1e-4]), corrected)
    return tried(problem, suspect, Score(np.array([lost]), np.ones(1), 0.0), np.inf)


def _norm(jump: Jump) -> float:
    return float(np.linalg.norm(jump.size))


def jumps_of(
    sensor: str, t: Float[np.ndarray, " n"], x: Float[np.ndarray, "n axes"]
) -> list[Jump]:
    """All that stand out, the largest first; none of few samples, or of a rest."""
    seen = np.flatnonzero(np.isfinite(x).all(axis=1))
    if seen.size < 4 * HALF:
        return []
    step, slope = _filters()
    shown, dt = x[seen], float(np.median(np.diff(t[seen])))
    found = np.array([np.correlate(axis, step, "valid") for axis in shown.T]).T
    slopes = np.array([np.correlate(axis, slope, "valid") for axis in shown.T]).T / dt
    size = np.linalg.norm(found, axis=1)
    scatter = float(np.median(size) / np.sqrt(chdtri(x.shape[1], 0.5)))
    # Around a jump the filter shows the same one again.
    tops = argrelmax(np.pad(size, 1), order=HALF)[0] - 1
    far = [k for k in tops if size[k] > FAR * scatter > 0]
    return [
        Jump(sensor, int(seen[k + HALF]), size[k] / scatter, found[k], slopes[k])
        for k in sorted(far, key=lambda k: -size[k])
    ]


def _filters() -> tuple[np.ndarray, np.ndarray]:
    """That of the step at the middle of so many samples, and of the slope there."""
    k = np.arange(-HALF, HALF) + 0.5
    powers = np.vander(k / HALF, DEGREE + 1, increasing=True)
    by = np.linalg.pinv(np.column_stack([powers, k > 0]))
    return by[-1], by[1] / HALF
