"""Suspects that a sensor's error has a course: in time, or with what it shows.

What the sensors of a recording show, and the same changed.

A gyro may have another scale where it turns the other way, or at high rates, and a lens
another one at its edge. Of what an axis shows, `y`, the error is

    a |y| + b y |y| / m  of a gyro,    a y^2 / m + b y^3 / m^2  of a position

with `m` the largest that is shown, so that `a` and `b` are errors of scale.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Float
from scipy.optimize import fminbound
from scipy.spatial.transform import Rotation

from orbident.diagnosis.rings import CYCLES, at_even_times, narrow_line
from orbident.diagnosis.suspects import Numbers, Suspect
from orbident.estimation.estimate import Estimate
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.output_error.sensors import COMPONENTS
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
    column = sensor if sensor in recording.columns else f"{sensor}.position"
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
"""rad, rad/s or m, or relative: far below what would be seen."""

MOST = 0.1
"""Relative: no instrument's scale changes by more."""


def drifts(problem: MomentumProblem) -> Iterator[Suspect]:
    """Sensors whose error grows with time; a position's would be a velocity."""
    t = problem.recording.t
    elapsed = (t - t[0])[:, None] / (t[-1] - t[0])
    named = {"gyro": "the bias of the gyro", "attitude": "the attitude"}
    for sensor, what in named.items():

        def words(c: Numbers, what: str = what) -> str:
            size = np.linalg.norm(c)
            return f"{what} drifts by {size:.2g} (SI) over the recording"

        if problem.recording.has(f"{sensor}.x"):
            yield shifted(sensor, elapsed, axes_of(problem, sensor), words)


def vibrations(problem: MomentumProblem, shown: Estimate) -> Iterator[Suspect]:
    """A tracked point that swings evenly beside the robot, at the line of what is left.

    Args:
        problem: as it was fitted.
        shown: its fit.
    """
    for signal in shown.signals:
        if signal.name != "position" or signal.t.size <= 2 * CYCLES:
            continue
        t, left = at_even_times(signal)
        line = narrow_line(left)
        if line is None:
            continue
        f = _frequency(t, left, line)

        def words(c: Numbers, f: float = f) -> str:
            size = np.linalg.norm(c.reshape(2, -1), axis=0).max()
            return (
                f"the position swings by {size:.2g} m at {f:.2g} Hz, as where the "
                "tracked point is on a mast, the table rocks, or a mass slides to and "
                "fro in the robot"
            )

        phase = 2 * np.pi * f * problem.recording.t
        courses = np.column_stack([np.sin(phase), np.cos(phase)])
        yield shifted("position", courses, axes_of(problem, "position"), words)


def _frequency(
    t: Float[np.ndarray, " n"], x: Float[np.ndarray, "n axes"], line: int
) -> float:
    """That of a line, Hz, where the sum over all samples is largest."""
    step = 1 / (t.size * (t[1] - t[0]))

    def less_than_all(f: float) -> float:
        return -float(np.sum(np.abs(np.exp(2j * np.pi * f * t) @ x) ** 2))

    found = fminbound(less_than_all, (line - 1) * step, (line + 1) * step)
    return float(np.array(found))


def curved_scales(problem: MomentumProblem) -> Iterator[Suspect]:
    """One of the gyro and one of the position."""
    for sensor in ("gyro", "position"):
        if problem.recording.has(f"{sensor}.x"):
            yield _curved(problem, sensor)


def _curved(problem: MomentumProblem, sensor: str) -> Suspect:
    axes = axes_of(problem, sensor)
    # What it shows along each axis, over the largest.
    along = problem.recording.vector(sensor) @ axes.T
    most = np.nanmax(np.abs(along))
    y = along / most
    even = np.abs(y) if sensor == "gyro" else y**2
    odd = y * even

    def words(c: Numbers) -> str:
        off = np.linalg.norm(c.reshape(2, -1), axis=0).max()
        return (
            f"the scale of the {sensor} depends on what it shows, by up to {off:.2g} "
            + ("(it is not linear)" if sensor == "gyro" else "(as behind a lens)")
        )

    def corrected(problem: MomentumProblem, c: Numbers) -> MomentumProblem:
        a, b = c.reshape(2, -1)
        error = most * (even * a + odd * b) @ axes
        # Samples hold only a first guess of the base's motion.
        return replace(problem, recording=less(problem.recording, sensor, error))

    return Suspect(words, np.full(2 * len(axes), SMALL), corrected, MOST)


def shifted(
    sensor: str,
    courses: Float[np.ndarray, "n courses"],
    axes: Float[np.ndarray, "numbers axes"],
    words: Callable[[Numbers], str],
) -> Suspect:
    """An error of so much along each axis times each course; course by course."""

    def corrected(problem: MomentumProblem, c: Numbers) -> MomentumProblem:
        error = courses @ c.reshape(courses.shape[1], -1) @ axes
        changed = less(problem.recording, sensor, error)
        # Samples hold the motion of joints, and only a first guess of the base's.
        if sensor.startswith("joint."):
            return problem.amended(recording=changed)
        return replace(problem, recording=changed)

    return Suspect(words, np.full(courses.shape[1] * len(axes), SMALL), corrected)


def axes_of(problem: MomentumProblem, sensor: str) -> Float[np.ndarray, "axes all"]:
    """Those of a sensor in which it says something."""
    if sensor.startswith("joint."):
        return np.eye(1)
    turning, moving = problem.robot.conserved_axes
    return np.eye(3)[list(turning if sensor in ("gyro", "attitude") else moving)]
