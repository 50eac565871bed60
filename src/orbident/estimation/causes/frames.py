"""Suspects beside the robot file: inertial axes, unknown wheels, outer torques."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from orbident.estimation.causes.suspects import Numbers, Suspect
from orbident.estimation.problem import MomentumProblem
from orbident.model.minimal_sets import conserved_axes
from orbident.model.wheels import wheels_of
from orbident.recordings.recording import Recording
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
    if problem.recording.has("gyro.x"):
        yield _gyro_drift(axes)
    yield from _spin_down(problem)
    if problem.robot.motion != "planar":
        yield _missing_wheel(problem, axes)
    yield _torque(problem, axes)


def _inertial_axes(axes: Float[np.ndarray, "n 3"]) -> Suspect:
    def words(c: Numbers) -> str:
        angle = np.degrees(np.linalg.norm(c))
        return (
            "attitude and position are in different inertial axes (frames), turned by "
            f"{angle:.3g} deg"
        )

    def corrected(problem: MomentumProblem, c: Numbers) -> MomentumProblem:
        turned = Rotation.from_rotvec(c @ axes).apply(
            problem.recording.vector("position")
        )
        return replace(
            problem, recording=_with(problem, dict(zip("xyz", turned.T, strict=True)))
        )

    return Suspect(words, np.full(len(axes), SMALL), corrected)


def _gyro_drift(axes: Float[np.ndarray, "n 3"]) -> Suspect:
    def words(c: Numbers) -> str:
        size = np.linalg.norm(c)
        return f"the bias of the gyro drifts by {size:.2g} rad/s over the recording"

    def corrected(problem: MomentumProblem, c: Numbers) -> MomentumProblem:
        recording, part = problem.recording, _elapsed(problem)
        columns = {
            f"gyro.{k}": recording.columns[f"gyro.{k}"] - off * part
            for k, off in zip("xyz", c @ axes, strict=True)
        }
        changed = replace(recording, columns={**recording.columns, **columns})
        return replace(problem, recording=changed)

    return Suspect(words, np.full(len(axes), 0.1 * SMALL), corrected)


def _with(problem: MomentumProblem, position: dict[str, np.ndarray]) -> Recording:
    columns = {
        f"position.{k}": np.ascontiguousarray(column) for k, column in position.items()
    }
    recording = problem.recording
    return replace(recording, columns={**recording.columns, **columns})


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


def _missing_wheel(problem: MomentumProblem, axes: Float[np.ndarray, "n 3"]) -> Suspect:
    h = _size(problem)

    def words(c: Numbers) -> str:
        return (
            "a wheel is missing in the robot file: a constant momentum of "
            f"{h * np.linalg.norm(c):.3g} N m s in base axes is not declared"
        )

    def corrected(problem: MomentumProblem, c: Numbers) -> MomentumProblem:
        wheels = [Wheel(f"{EXTRA}_{k}", axis, 1.0) for k, axis in enumerate(axes)]
        steady = np.ones(problem.samples.t.size)
        return _with_wheels(problem, wheels, [h * each * steady for each in c])

    return Suspect(words, np.full(len(axes), SMALL), corrected)


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
        recording=replace(recording, columns={**recording.columns, **columns}),
    )
