"""Sensors that jump from one sample to the next, as no smooth motion does.

If all sensors jump at once, time did. Rates leap with the motion, so a gyro's jumps are
looked for in what is left of it after the fit.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import chain

import numpy as np

from orbident.diagnosis.shifts import axes_of, shifted, shown_by
from orbident.diagnosis.suspects import Numbers, Scores, Suspect, tried
from orbident.diagnosis.trial import Trial
from orbident.estimation.clock_search import WORTH
from orbident.estimation.estimate import Estimate
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.unknowns import Score
from orbident.files.names import joined
from orbident.preprocessing.leaps import Jump, jumps_of

MOST = 4
"""Jumps of one sensor that are put right: more of them are noise."""

TOGETHER = 0.5
"""Part of the joints and sensors that jump at once where time does."""

ODD = 100.0
"""Times that a step differs more from usual ones than any other does."""

ROUNDING = 1e-6
"""Part of a step by which times differ that files hold with few digits."""

RATES = ("gyro", "velocity")
OF_THE_BASE = ("position", "attitude", *RATES)


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
    for one in _odd_step(problem):
        yield one
        if one.accepted:
            return
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
        (first,) = Scores(problem, shown.solution).of([suspect])
        if first.fall > WORTH:
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

    words = (
        f"all sensors jump {at}: rows are missing (a gap) there, or the clock was set, "
        "and {:.3g} s of time are lost"
    )
    return _later(problem, row, lost, words)


def _odd_step(problem: MomentumProblem) -> Iterator[Trial]:
    """One row that is later than all others are after the row before them."""
    steps = np.diff(problem.recording.t)
    step = float(np.median(steps))
    *_, next_one, odd = np.argsort(np.abs(steps - step))
    if abs(steps[odd] - step) > ODD * max(abs(steps[next_one] - step), ROUNDING * step):
        row, lost = int(odd) + 1, float(step - steps[odd])
        way, at = "back" if lost > 0 else "forward", problem.recording.t[row]
        words = f"the clock was set {way} by {abs(lost):.3g} s at t = {at:.4g} s"
        for one in _later(problem, row, lost, f"{words}, as the times of rows show"):
            yield one._replace(seen=True)


def _later(
    problem: MomentumProblem, row: int, lost: float, words: str
) -> Iterator[Trial]:
    """Tried: all rows from one on are so much later, s; the words may name that."""

    def corrected(problem: MomentumProblem, c: Numbers) -> MomentumProblem:
        recording = problem.recording
        later = np.arange(recording.t.size) >= row
        return problem.amended(recording=replace(recording, t=recording.t + c * later))

    suspect = Suspect(lambda c: words.format(c[0]), np.array([1e-4]), corrected)
    return tried(problem, suspect, Score(np.array([lost]), np.ones(1), 0.0), np.inf)


def _norm(jump: Jump) -> float:
    return float(np.linalg.norm(jump.size))
