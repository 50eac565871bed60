"""Suspects whose error has a course in time: steps, drifts, joints that give way.

What the sensors of a recording show, and the same changed.

Sensors that jump from one sample to the next, as no smooth motion does.

A polynomial and a step at its middle are fitted to the samples around every one. The
step is a fixed filter of them, and where it stands far out of all that it gives over
the recording, the sensor jumped. If all sensors jump at once, time did. Rates leap with
the motion, so a gyro's jumps are looked for in what is left of it after the fit.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation
from scipy.special import chdtri

from orbident.diagnosis.suspects import Numbers, Scores, Suspect, tried
from orbident.diagnosis.trial import Trial
from orbident.estimation.clock_search import misfit
from orbident.estimation.estimate import Estimate
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.output_error.sensors import COMPONENTS
from orbident.estimation.unknowns import Score
from orbident.model.minimal_sets import conserved_axes
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot


def shown_by(
    robot: Robot, recording: Recording
) -> dict[str, Float[np.ndarray, "n axes"]]:
    """What each joint and each sensor of the base shows, smooth where the motion is."""
    tables = {
        f"joint.{name}": recording.column(f"joint.{name}.position")[:, None]
        for name in robot.joint_names
        if recording.has(f"joint.{name}.position")
    }
    for sensor, parts in COMPONENTS.items():
        if recording.has(*(f"{sensor}.{part}" for part in parts)):
            tables[sensor] = recording.vector(sensor, parts)
    if "attitude" in tables:
        tables["attitude"] = _continuous(tables["attitude"])
    return tables


def _continuous(x: Float[np.ndarray, "n 4"]) -> Float[np.ndarray, "n 4"]:
    """`x` and `-x` are one attitude: that nearer to the one before."""
    seen = np.flatnonzero(np.isfinite(x).all(axis=1))
    along = np.sum(x[seen[1:]] * x[seen[:-1]], axis=1)
    x[seen[1:]] *= np.cumprod(np.where(along < 0, -1.0, 1.0))[:, None]
    return x


def of_vector(
    sensor: str, x: Float[np.ndarray, "n axes"]
) -> dict[str, Float[np.ndarray, " n"]]:
    """The columns of a vector or quaternion."""
    names = "xyzw"[: x.shape[1]]
    parts = zip(names, np.ascontiguousarray(x.T), strict=True)
    return {f"{sensor}.{k}": part for k, part in parts}


def without(
    recording: Recording, sensor: str, rows: Bool[np.ndarray, " n"]
) -> Recording:
    """Without these samples of a sensor, or of a joint."""
    left_out = {
        name: np.where(rows, np.nan, column)
        for name, column in recording.columns.items()
        if name.startswith(f"{sensor}.")
    }
    return recording.with_columns(left_out)


def less(
    recording: Recording, sensor: str, error: Float[np.ndarray, "n axes"]
) -> Recording:
    """What a sensor would show without an error.

    Args:
        recording: with the sensor.
        sensor: `joint.<name>`, a column, a vector, or the attitude.
        error: of an attitude the turn of the sensor in its own axes, rad.
    """
    column = f"{sensor}.position" if sensor.startswith("joint.") else sensor
    if column in recording.columns:
        return recording.with_columns({column: recording.columns[column] - error[:, 0]})
    if sensor != "attitude":
        right = recording.vector(sensor) - error
        return recording.with_columns(of_vector(sensor, right))
    x = recording.vector(sensor, "xyzw").copy()
    seen = np.isfinite(x).all(axis=1)
    right = Rotation.from_quat(x[seen]) * Rotation.from_rotvec(-error[seen])
    x[seen] = right.as_quat()
    return recording.with_columns(of_vector(sensor, x))


SMALL = 1e-5
"""rad, rad/s or m: far below what would be seen."""

BETWEEN = 0.1
"""Part of a joint's usual rate below which a gear with play is between its sides."""

SMALL_BEND = 1e-4
"""s^2: of a joint that gives way at 16 Hz."""


def step(problem: MomentumProblem, sensor: str, row: int) -> Suspect:
    """The suspect that a sensor is off by a constant from one row on."""
    t, axes = problem.recording.t, axes_of(problem, sensor)
    joint = sensor.partition(".")[2]

    def words(c: Numbers) -> str:
        size = f"a jump (a step) of {np.linalg.norm(c):.2g} (SI) at t = {t[row]:.4g} s"
        if joint:
            return f"joint {joint} slips: its position has {size}"
        return f"the {sensor} has {size}"

    return _shifted(sensor, 1.0 * (np.arange(t.size) >= row), axes, words)


def drifts(problem: MomentumProblem) -> Iterator[Suspect]:
    """Sensors whose error grows with time; a position's would be a velocity."""
    t = problem.recording.t
    elapsed = (t - t[0]) / (t[-1] - t[0])
    named = {"gyro": "the bias of the gyro", "attitude": "the attitude"}
    for sensor, what in named.items():

        def words(c: Numbers, what: str = what) -> str:
            size = np.linalg.norm(c)
            return f"{what} drifts by {size:.2g} (SI) over the recording"

        if problem.recording.has(f"{sensor}.x"):
            yield _shifted(sensor, elapsed, axes_of(problem, sensor), words)


def joint_errors(problem: MomentumProblem) -> Iterator[Suspect]:
    """Encoders whose error has a course: in time, over a turn, or with the load.

    One that is not in the middle of its axis is off by `a sin(q) + b cos(q)`. On the
    motor of a joint that gives way it shows `q_m = q + c qdd`, and on that of one whose
    gear has play `q_m = q + c sign(qd)`.
    """
    names, t = problem.robot.joint_names, problem.samples.t
    if not names:
        return
    position = np.column_stack(problem.samples.q)
    moved = np.column_stack(problem.samples.qd)
    seen = np.isfinite(moved).all(axis=1)
    inside = np.clip(problem.recording.t, *t[seen][[0, -1]])
    q = CubicSpline(t[seen], position[seen])(inside)
    rates = CubicSpline(t[seen], moved[seen])
    qd, qdd = rates(inside), rates(inside, 1)
    slow = np.maximum(BETWEEN * np.std(moved[seen], axis=0), SMALL)
    elapsed = (inside - inside[0]) / (inside[-1] - inside[0])

    def most(c: Numbers) -> tuple[str, float]:
        """The joint whose numbers are the largest, and how large."""
        size = np.linalg.norm(c.reshape(len(names), -1), axis=1)
        return names[int(np.argmax(size))], float(size.max())

    def drifting(c: Numbers) -> str:
        return "joint {}: its position drifts by {:.2g} over the recording".format(
            *most(c)
        )

    def off_centre(c: Numbers) -> str:
        return (
            "the encoder of joint {} is off the centre of its axis (an error of {:.2g} "
            "rad over each turn)".format(*most(c))
        )

    def playing(c: Numbers) -> str:
        name, size = most(c)
        return (
            f"gears have backlash, between an encoder on the motor and the link: joint "
            f"{name} has a play of {2 * size:.2g} rad"
        )

    def soft(c: Numbers) -> str:
        name, bend = most(np.maximum(c, SMALL**2))
        return (
            "joints are flexible, between an encoder on the motor and the link: joint "
            f"{name} gives way, as if it swung at {1 / (2 * np.pi * bend**0.5):.2g} Hz"
        )

    one = np.ones(len(names))
    yield _of_joints(names, drifting, SMALL * one, [elapsed[:, None] * one])
    yield _of_joints(
        names, off_centre, SMALL * np.tile(one, 2), [np.sin(q), np.cos(q) - 1]
    )
    # No play is less than none, and no spring pushes the other way.
    yield _of_joints(names, playing, SMALL * one, [qd / np.hypot(qd, slow)], least=0.0)
    yield _of_joints(names, soft, SMALL_BEND * one, [qdd], least=0.0)


def _of_joints(
    names: Sequence[str],
    words: Callable[[Numbers], str],
    small: Numbers,
    courses: Sequence[Float[np.ndarray, "n joints"]],
    least: float = -np.inf,
) -> Suspect:
    """An error of each joint by so much of each course; joint by joint."""
    by_joint = np.stack(courses, axis=2)

    def corrected(problem: MomentumProblem, c: Numbers) -> MomentumProblem:
        recording = problem.recording
        sizes = np.maximum(c, least).reshape(len(names), -1)
        for k, name in enumerate(names):
            error = by_joint[:, k] @ sizes[k]
            recording = less(recording, f"joint.{name}", error[:, None])
        return problem.amended(recording=recording)

    return Suspect(words, small, corrected)


def _shifted(
    sensor: str,
    course: Float[np.ndarray, " n"],
    axes: Float[np.ndarray, "numbers axes"],
    words: Callable[[Numbers], str],
) -> Suspect:
    """An error of so much along each axis, times its course."""

    def corrected(problem: MomentumProblem, c: Numbers) -> MomentumProblem:
        changed = less(problem.recording, sensor, np.outer(course, c @ axes))
        # Samples hold the motion of joints, and only a first guess of the base's.
        if sensor.startswith("joint."):
            return problem.amended(recording=changed)
        return replace(problem, recording=changed)

    return Suspect(words, np.full(len(axes), SMALL), corrected)


def axes_of(problem: MomentumProblem, sensor: str) -> Float[np.ndarray, "axes all"]:
    """Those of a sensor in which it says something."""
    if sensor.startswith("joint."):
        return np.eye(1)
    turning, moving = conserved_axes(problem.robot)
    return np.eye(3)[list(turning if sensor in ("gyro", "attitude") else moving)]


HALF, DEGREE = 10, 4
"""Samples before and after, and of the polynomial through them."""

FAR = 8.0
"""Deviations of the filter's own scatter."""

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


def jumps(problem: MomentumProblem, shown: Estimate) -> Iterator[Trial]:
    """Tried: the sensor, or the time, put right from then on."""
    found = sorted(_of_samples(problem), key=lambda jump: -jump.times)
    at_once = [jump for jump in found if abs(jump.row - found[0].row) <= 1]
    if len(at_once) > max(
        1.0, TOGETHER * len(shown_by(problem.robot, problem.recording))
    ):
        yield from _lost_rows(problem, at_once)
        return
    # A rate may leap because the motion does.
    slow = [jump for jump in found if jump.sensor not in RATES]
    if slow and shown.solution is not None:
        suspect = step(problem, slow[0].sensor, slow[0].row)
        first = Scores(problem, shown.solution).of(suspect)
        if first.values.size:
            trials = tried(problem, suspect, first, misfit(shown))
            yield from (one._replace(seen=True) for one in trials)


def steps(problem: MomentumProblem, shown: Estimate) -> Iterator[Suspect]:
    """Smaller ones of the base's sensors, in what is left of its motion."""
    for signal in shown.signals:
        if signal.name in OF_THE_BASE:
            left = signal.measured - signal.predicted
            jump = jump_of(signal.name, signal.t, left)
            if jump is not None and jump.times > FAR:
                at = signal.t[jump.row]
                row = int(np.argmin(np.abs(problem.recording.t - at)))
                yield step(problem, signal.name, row)


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


def _of_samples(problem: MomentumProblem) -> Iterator[Jump]:
    for sensor, x in shown_by(problem.robot, problem.recording).items():
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
    scatter = float(np.median(size) / np.sqrt(chdtri(x.shape[1], 0.5)))
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
