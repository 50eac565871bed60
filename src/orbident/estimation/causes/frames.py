"""Suspects beside the robot file: inertial axes, unknown wheels, outer torques."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from orbident.estimation.causes.linear_test import FALLS, ROWS
from orbident.estimation.causes.shifts import of_vector, with_columns
from orbident.estimation.causes.suspects import Numbers, Score, Suspect, tried
from orbident.estimation.causes.trial import Trial
from orbident.estimation.linear_fits import rows_of
from orbident.estimation.problem import MomentumProblem
from orbident.model.minimal_sets import conserved_axes
from orbident.model.wheels import wheels_of
from orbident.robot.description import Wheel

SMALL = 1e-4
"""rad, or of the wheels' momentum."""

POWERS = (2, 3, 4)
"""Powers of time: the momentum changes so under a torque that changes."""

EXTRA = "unknown"
"""Begins the names of wheels that stand for momentum which the robot file lacks."""


def beside(problem: MomentumProblem) -> Iterator[Suspect]:
    """What is neither an instrument's error nor one of geometry."""
    turning, _ = conserved_axes(problem.robot)
    axes = np.eye(3)[list(turning)]
    if problem.recording.has("position.x", "attitude.x"):
        yield _inertial_axes(axes)
    yield from _spin_down(problem)
    if problem.robot.motion != "planar":
        for k, wheel in enumerate(problem.robot.wheels):
            yield _wheel_axis(k, wheel)
    yield _torque(problem, axes)


def _inertial_axes(axes: Float[np.ndarray, "n 3"]) -> Suspect:
    def words(c: Numbers) -> str:
        angle = np.degrees(np.linalg.norm(c))
        return (
            "attitude and position are in different inertial axes (frames), turned by "
            f"{angle:.3g} deg"
        )

    def corrected(problem: MomentumProblem, c: Numbers) -> MomentumProblem:
        R = Rotation.from_rotvec(c @ axes)
        turned = R.apply(problem.recording.vector("position"))
        columns = of_vector("position", turned)
        return replace(problem, recording=with_columns(problem.recording, columns))

    return Suspect(words, np.full(len(axes), SMALL), corrected)


def _wheel_axis(k: int, wheel: Wheel) -> Suspect:
    across = across_of(wheel.axis)

    def words(c: Numbers) -> str:
        angle = np.degrees(np.linalg.norm(c))
        return (
            f"the axis of wheel {wheel.name} in the robot file is tilted by "
            f"{angle:.2g} deg"
        )

    def corrected(problem: MomentumProblem, c: Numbers) -> MomentumProblem:
        axis = Rotation.from_rotvec(c @ across).apply(wheel.axis)
        wheels = list(problem.robot.wheels)
        wheels[k] = replace(wheels[k], axis=axis)
        return replace(problem, robot=replace(problem.robot, wheels=tuple(wheels)))

    return Suspect(words, np.full(2, SMALL), corrected)


def _spin_down(problem: MomentumProblem) -> Iterator[Suspect]:
    """Speeds that change though they are recorded as constant."""
    for k, name in enumerate(problem.robot.wheel_names):
        speed = problem.samples.qd_rw[k]
        if np.nanstd(speed) > 1e-2 * abs(np.nanmean(speed)):
            continue

        def words(c: Numbers, name: str = name) -> str:
            return (
                f"the speed of wheel {name} changes by {100 * c[0]:.2g} % over the "
                "recording, which shows it as constant"
            )

        def corrected(
            problem: MomentumProblem, c: Numbers, k: int = k
        ) -> MomentumProblem:
            part = _elapsed(problem)
            samples = problem.samples
            wheel = problem.robot.wheels[k]
            extra = replace(wheel, name=f"{EXTRA}_{wheel.name}")
            return _with_wheels(
                problem, [extra], [c[0] * part * np.nanmean(samples.qd_rw[k])]
            )

        yield Suspect(words, np.array([SMALL]), corrected)


def missing_wheel(problem: MomentumProblem) -> Iterator[Trial]:
    """A constant momentum in base axes, if Eq. 24 has a place for one.

    Along that of wheels whose speeds are constant it would be another scale.
    """
    if problem.robot.motion == "planar" or not problem.robot.wheels:
        return
    h = wheels_of(problem.robot).A_rw @ np.nanmean(problem.samples.qd_rw, axis=1)
    across = across_of(h)
    missing = _missing_momentum(problem, across)
    if missing is None:
        return

    def words(c: Numbers) -> str:
        return (
            "a wheel is missing in the robot file: a constant momentum of "
            f"{np.linalg.norm(c):.3g} N m s or more in base axes is not declared"
        )

    def corrected(problem: MomentumProblem, c: Numbers) -> MomentumProblem:
        wheels = [Wheel(f"{EXTRA}_{k}", axis, 1.0) for k, axis in enumerate(across)]
        steady = np.ones(problem.samples.t.size)
        return _with_wheels(problem, wheels, [each * steady for each in c])

    small = np.full(len(across), SMALL * np.linalg.norm(h))
    suspect = Suspect(words, small, corrected)
    yield from tried(problem, suspect, Score(missing, np.ones(2), 0.0), np.inf)


def _missing_momentum(
    problem: MomentumProblem, axes: Float[np.ndarray, "n 3"]
) -> Float[np.ndarray, " n"] | None:
    """`h` of `Y pi - R_0^T h_cm + h = -A_rw qd_rw`; None where it explains little."""
    regressors, wheels = problem.sets.regressors, wheels_of(problem.robot)
    batch = problem.samples.batch(0, ROWS)
    rows, _ = rows_of(regressors, wheels, None, batch, bool(problem.samples.drift))
    rows = rows.reshape(len(batch.turning), 3, -1)[batch.turning]
    known, b = rows[..., :-1].reshape(3 * len(rows), -1), rows[..., -1].ravel()
    A = np.hstack([np.tile(axes.T, (len(rows), 1)), known])
    x, without = np.linalg.lstsq(A, b)[0], np.linalg.lstsq(known, b)[0]
    before, after = np.linalg.norm(b - known @ without), np.linalg.norm(b - A @ x)
    return x[: len(axes)] if before > FALLS * after else None


def across_of(axis: Float[np.ndarray, "3"]) -> Float[np.ndarray, "2 3"]:
    """Two directions across an axis."""
    return np.linalg.svd(axis[None])[2][1:]


def _torque(problem: MomentumProblem, axes: Float[np.ndarray, "n 3"]) -> Suspect:
    """The robot's momentum in inertial axes grows by `c f(t)`: that of wheels falls."""
    h = _size(problem)

    def words(c: Numbers) -> str:
        T = float(np.ptp(problem.samples.t))
        size = h / T * np.linalg.norm(np.reshape(c, (len(POWERS), -1)).sum(axis=0))
        return (
            "an external torque that changes with time acts, by drag, friction or "
            f"another disturbance, of about {size:.1g} N m"
        )

    def corrected(problem: MomentumProblem, c: Numbers) -> MomentumProblem:
        part = _elapsed(problem)
        by_power = part[:, None] ** np.array(POWERS)
        gained = by_power @ np.reshape(c, (len(POWERS), -1)) @ axes
        x = np.column_stack(problem.samples.x_WB)
        seen = np.isfinite(x).all(axis=1)
        lost = np.zeros_like(gained)
        lost[seen] = -h * Rotation.from_quat(x[seen]).inv().apply(gained[seen])
        wheels = [Wheel(f"{EXTRA}_{k}", axis, 1.0) for k, axis in enumerate(axes)]
        return _with_wheels(problem, wheels, [lost @ axis for axis in axes])

    return Suspect(words, np.full(len(POWERS) * len(axes), SMALL), corrected)


def _elapsed(problem: MomentumProblem) -> Float[np.ndarray, " n"]:
    t = problem.samples.t
    return (t - t[0]) / (t[-1] - t[0])


def _size(problem: MomentumProblem) -> float:
    """The size of the momentum of all wheels, N m s."""
    speeds = np.nanmean(np.abs(np.array(problem.samples.qd_rw)), axis=1)
    return float(np.linalg.norm(np.abs(wheels_of(problem.robot).A_rw) @ speeds))


def _with_wheels(
    problem: MomentumProblem, wheels: list[Wheel], speeds: list[np.ndarray]
) -> MomentumProblem:
    robot, samples, recording = problem.robot, problem.samples, problem.recording
    columns = {
        f"wheel.{wheel.name}.speed": speed
        for wheel, speed in zip(wheels, speeds, strict=True)
    }
    return replace(
        problem,
        robot=replace(robot, wheels=(*robot.wheels, *wheels)),
        samples=replace(samples, qd_rw=(*samples.qd_rw, *speeds)),
        recording=with_columns(recording, columns),
    )
