"""Sensors that jump from one sample to the next, as no smooth motion does.

A polynomial and a step at its middle are fitted to the samples around every one. The
step is a fixed filter of them, and where it stands far out of all that it gives over
the recording, the sensor jumped. If all sensors jump at once, time did.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.estimation.causes.suspects import Numbers, Score, Suspect, tried
from orbident.estimation.causes.trial import Trial, trial
from orbident.estimation.output_error.sensors import NORMAL
from orbident.estimation.problem import MomentumProblem
from orbident.recordings.recording import Recording

HALF, DEGREE = 10, 4
"""Samples before and after, and of the polynomial through them."""

FAR = 8.0
"""Deviations of the filter's own scatter."""

TOGETHER = 0.5
"""Part of the joints and sensors that jump at once where time does."""

MASKED = ("position", "attitude", "gyro", "velocity")
"""Sensors without which, from then on, the rest may still be identified."""


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


def jumps(problem: MomentumProblem) -> Iterator[Trial]:
    """Tried: the sensor put right, or left out from then on."""
    found = sorted(_all(problem), key=lambda jump: -jump.times)
    if not found:
        return
    first = found[0]
    at_once = [jump for jump in found if abs(jump.row - first.row) <= 1]
    if len(at_once) > max(1.0, TOGETHER * len(_vectors(problem))):
        yield from _lost_rows(problem, at_once)
        return
    sensor = first.sensor
    at = f"at t = {problem.recording.t[first.row]:.4g} s"
    if sensor in MASKED:
        words = (
            f"the {sensor} has a jump (a step) of {np.linalg.norm(first.size):.2g} "
            f"(SI) {at}: without its samples from then on the recording is accepted"
        )
        yield _without(problem, words, sensor, first.row)
    else:
        yield from _slipped(problem, first)


def _slipped(problem: MomentumProblem, jump: Jump) -> Iterator[Trial]:
    """A joint, put right from then on."""
    name = f"{jump.sensor}.position"
    at = f"at t = {problem.recording.t[jump.row]:.4g} s"

    def words(c: Numbers) -> str:
        joint = jump.sensor.partition(".")[2]
        return f"joint {joint} slips: its position has a jump of {c[0]:.3g} (SI) {at}"

    def corrected(problem: MomentumProblem, c: Numbers) -> MomentumProblem:
        recording = problem.recording
        later = np.arange(recording.t.size) >= jump.row
        column = recording.columns[name] - c[0] * later
        changed = replace(recording, columns={**recording.columns, name: column})
        return problem.amended(recording=changed)

    suspect = Suspect(words, np.array([1e-5]), corrected)
    return tried(problem, suspect, Score(jump.size, np.ones(1), 0.0))


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
    return tried(problem, suspect, Score(np.array([lost]), np.ones(1), 0.0))


def _norm(jump: Jump) -> float:
    return float(np.linalg.norm(jump.size))


def _without(problem: MomentumProblem, words: str, sensor: str, row: int) -> Trial:
    recording = problem.recording
    columns = {
        name: np.where(np.arange(column.size) < row, column, np.nan)
        if name.startswith(f"{sensor}.")
        else column
        for name, column in recording.columns.items()
    }
    try:
        amended = problem.amended(recording=replace(recording, columns=columns))
    except InputError:
        return Trial("", False, np.inf)
    return trial(words, amended)


def _vectors(problem: MomentumProblem) -> Mapping[str, Float[np.ndarray, "n axes"]]:
    """What each sensor shows, smooth where the motion is."""
    recording, robot = problem.recording, problem.robot
    vectors = {
        f"joint.{name}": recording.column(f"joint.{name}.position")[:, None]
        for name in robot.joint_names
        if recording.has(f"joint.{name}.position")
    }
    for name in MASKED:
        if recording.has(f"{name}.x"):
            vectors[name] = recording.vector(name)
    if recording.has("attitude.w"):
        vectors["attitude"] = _continuous(recording)
    return vectors


def _continuous(recording: Recording) -> Float[np.ndarray, "n 4"]:
    """`x` and `-x` are one attitude: that nearer to the one before."""
    x = recording.vector("attitude", "xyzw").copy()
    seen = np.flatnonzero(np.isfinite(x).all(axis=1))
    along = np.sum(x[seen[1:]] * x[seen[:-1]], axis=1)
    x[seen[1:]] *= np.cumprod(np.where(along < 0, -1.0, 1.0))[:, None]
    return x


def _all(problem: MomentumProblem) -> Iterator[Jump]:
    for sensor, x in _vectors(problem).items():
        jump = jump_of(sensor, problem.recording.t, x)
        if jump is not None and jump.times > FAR:
            yield jump


def jump_of(
    sensor: str, t: Float[np.ndarray, " n"], x: Float[np.ndarray, "n axes"]
) -> Jump | None:
    """The largest one; None of a sensor with few samples, or that rests."""
    seen = np.flatnonzero(np.isfinite(x).all(axis=1))
    if seen.size < 4 * HALF:
        return None
    step, slope = _filters()
    shown, dt = x[seen], float(np.median(np.diff(t[seen])))
    found = np.array([np.correlate(axis, step, "valid") for axis in shown.T]).T
    slopes = np.array([np.correlate(axis, slope, "valid") for axis in shown.T]).T / dt
    size = np.linalg.norm(found, axis=1)
    scatter = NORMAL * float(np.median(size))
    k = int(np.argmax(size))
    if not scatter > 0:
        return None
    return Jump(sensor, int(seen[k + HALF]), size[k] / scatter, found[k], slopes[k])


def _filters() -> tuple[np.ndarray, np.ndarray]:
    """That of the step at the middle of so many samples, and of the slope there."""
    k = np.arange(-HALF, HALF) + 0.5
    powers = np.vander(k / HALF, DEGREE + 1, increasing=True)
    by = np.linalg.pinv(np.column_stack([powers, k > 0]))
    return by[-1], by[1] / HALF
