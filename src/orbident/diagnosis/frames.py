"""Suspects beside the robot file: axes, unknown wheels, torques, points of links."""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from orbident.diagnosis.linear_test import FALLS, ROWS
from orbident.diagnosis.shifts import of_vector
from orbident.diagnosis.suspects import Numbers, Suspect, tried
from orbident.diagnosis.trial import Trial
from orbident.estimation.linear_fits import rows_of
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.unknowns import Score
from orbident.model.core_robot import wheels_of
from orbident.model.kinematics import inertia, poses
from orbident.model.rotations import quaternion_matrix
from orbident.preprocessing.histories import NO_NOISE
from orbident.robot.description import Robot, Wheel

SMALL = 1e-4
"""rad, N m s, or of the wheels' momentum."""

TINY = 1e-9
"""N m s: of a robot without wheels."""

Momentum = Float[np.ndarray, "n 3"]
"""Base axes, N m s."""

POWERS = (2, 3, 4)
"""Powers of time: the momentum changes so under a torque that changes."""

EXTRA = "unknown"
"""Begins the names of wheels that stand for momentum which the robot file lacks."""

LIGHT = 1e-9
"""kg m^2: the inertia of these wheels. They turn so fast that the noise which the robot
file declares for tachometers is nothing beside their speed."""


def beside(problem: MomentumProblem) -> Iterator[Suspect]:
    """What is neither an instrument's error nor one of geometry."""
    axes = np.eye(3)[list(problem.robot.conserved_axes[0])]
    yield from _spin_down(problem)
    if problem.robot.motion != "planar":
        if problem.recording.has("position.x", "attitude.x"):
            yield _inertial_axes()
        yield from _wheel_axes(problem)
        if problem.recording.has_vector("gyro"):
            yield _skewed_gyro()
    yield _torque(problem, axes)


def missing_wheel(problem: MomentumProblem) -> Iterator[Trial]:
    """A constant momentum in base axes, if Eq. 24 has a place for one.

    Along that of wheels whose speeds are constant it would be another scale.
    """
    if problem.robot.motion == "planar" or not problem.robot.wheels:
        return
    across = across_of(np.nanmean(_momenta(problem).sum(axis=0), axis=0))
    missing = _missing_momentum(problem, across)
    if missing is None:
        return

    def words(c: Numbers) -> str:
        return (
            "a wheel is missing in the robot file: a constant momentum of "
            f"{np.linalg.norm(c):.3g} N m s or more in base axes is not declared"
        )

    steady = np.ones((problem.samples.t.size, 1))
    small = np.full(len(across), SMALL)
    suspect = _with_momentum(words, small, lambda c: steady * (c @ across))
    yield from tried(problem, suspect, Score(missing, np.ones(2), 0.0), np.inf)


def point_of_a_link(problem: MomentumProblem) -> Iterator[Trial]:
    """The tracked point is on a link, where that is likelier by the masses of CAD.

    The system CM is at `p_S + R_0 r_cm` and moves evenly; a point of body `i` at `x` in
    its frame is at `p_S + R_0 (d_i + R_i x)`. Residuals of Eq. 31 cannot tell, since it
    shows a point of any link as one of the base of another robot.
    """
    robot, samples = problem.robot, problem.samples
    if not (robot.joints and problem.recording.has_vector("position")):
        return
    axes = list(robot.conserved_axes[1])
    q, x_WB = np.column_stack(samples.q), np.column_stack(samples.x_WB)
    p = problem.recording.vector("position")[:, axes]
    seen = np.isfinite(np.hstack([q, x_WB, p])).all(axis=1)
    if not seen.any():
        return
    at, t = poses(robot, q[seen]), samples.t[seen]
    R_WB = quaternion_matrix(x_WB[seen])
    from_S = inertia(robot, q[seen]).r_cm
    ones, left, offsets = np.ones(t.size), list[float](), list[np.ndarray]()
    for body in range(len(robot.bodies)):
        of_point = (R_WB @ at.R[:, body])[:, axes][:, :, axes]
        even = (
            np.stack([ones, t], axis=1)[:, None, :, None] * np.eye(len(axes))[:, None]
        )
        A = np.concatenate([of_point, even.reshape(t.size, len(axes), -1)], axis=2)
        to_cm = np.einsum("nij,nj->ni", R_WB, from_S - at.d[:, body])[:, axes]
        b = (p[seen] + to_cm).ravel()
        A = A.reshape(b.size, -1)
        x = np.linalg.lstsq(A, b)[0]
        left.append(float(np.linalg.norm(b - A @ x)))
        offsets.append(x[: len(axes)])
    body = int(np.argmin(left))
    if left[0] > FALLS * left[body]:
        suspect = _on_a_link(robot, body, axes)
        first = Score(offsets[body], np.ones(len(axes)), 0.0)
        yield from tried(problem, suspect, first, np.inf)


def _on_a_link(robot: Robot, body: int, axes: list[int]) -> Suspect:
    """The tracked point is one of this body, so far off its origin."""

    def words(c: Numbers) -> str:
        joint = robot.joint_names[body - 1]
        return (
            f"the tracked point (the marker) is on link {robot.bodies[body]}, "
            f"{np.linalg.norm(c):.2g} m from joint {joint}, and not on the base"
        )

    def corrected(problem: MomentumProblem, c: Numbers) -> MomentumProblem:
        samples, recording = problem.samples, problem.recording
        at = poses(robot, np.column_stack(samples.q))
        R_WB = quaternion_matrix(np.column_stack(samples.x_WB))
        arm = np.einsum("nij,nj->ni", R_WB, at.arm(body, c @ np.eye(3)[axes]))
        right = recording.vector("position") - arm
        columns = of_vector("position", right)
        return problem.amended(recording=recording.with_columns(columns))

    return Suspect(words, np.full(len(axes), SMALL), corrected)


def _missing_momentum(
    problem: MomentumProblem, axes: Float[np.ndarray, "n 3"]
) -> Float[np.ndarray, " n"] | None:
    """`h` of `Y pi - R_0^T h_cm + h = -A_rw qd_rw`; None where it explains little."""
    regressors, wheels = problem.sets.regressors, wheels_of(problem.robot)
    batch = problem.samples.batch(0, ROWS)
    rows, _ = rows_of(regressors, wheels, None, batch, None)
    rows = rows.reshape(len(batch.turning), 3, -1)[batch.turning]
    known, b = rows[..., :-1].reshape(3 * len(rows), -1), rows[..., -1].ravel()
    A = np.hstack([np.tile(axes.T, (len(rows), 1)), known])
    x, without = np.linalg.lstsq(A, b)[0], np.linalg.lstsq(known, b)[0]
    before, after = np.linalg.norm(b - known @ without), np.linalg.norm(b - A @ x)
    return x[: len(axes)] if before > FALLS * after else None


def across_of(axis: Float[np.ndarray, "3"]) -> Float[np.ndarray, "2 3"]:
    """Two directions across an axis."""
    return np.linalg.svd(axis[None])[2][1:]


def _inertial_axes() -> Suspect:
    """In the plane it is the attitude sensor's misalignment (`instruments.py`)."""

    def words(c: Numbers) -> str:
        angle = np.degrees(np.linalg.norm(c))
        return (
            "attitude and position are in different inertial axes (frames), turned by "
            f"{angle:.3g} deg"
        )

    def corrected(problem: MomentumProblem, c: Numbers) -> MomentumProblem:
        R = Rotation.from_rotvec(c)
        turned = R.apply(problem.recording.vector("position"))
        columns = of_vector("position", turned)
        return replace(problem, recording=problem.recording.with_columns(columns))

    return Suspect(words, np.full(3, SMALL), corrected)


def _spin_down(problem: MomentumProblem) -> Iterator[Suspect]:
    """Speeds that change though they are recorded as constant."""
    for wheel, h in zip(problem.robot.wheels, _momenta(problem), strict=True):
        mean = np.nanmean(h, axis=0)
        if not _steady(h):
            continue

        def words(c: Numbers, name: str = wheel.name) -> str:
            return (
                f"the speed of wheel {name} changes by {100 * c[0]:.2g} % over the "
                "recording, which shows it as constant"
            )

        lost = np.outer(_elapsed(problem), mean)
        # No wheel loses more speed than it has.
        small, most = np.array([SMALL]), 1.0
        yield _with_momentum(words, small, lambda c, lost=lost: c[0] * lost, most)


def _steady(h: Momentum) -> bool:
    """Whether a wheel's momentum hardly changes."""
    mean = np.linalg.norm(np.nanmean(h, axis=0))
    return bool(np.linalg.norm(np.nanstd(h, axis=0)) <= 1e-2 * mean)


def _wheel_axes(problem: MomentumProblem) -> Iterator[Suspect]:
    names, recording = problem.robot.wheel_names, problem.recording
    read = not any(recording.has(f"wheel.{name}.position") for name in names)
    # Across a wheel that turns evenly all of these are the same.
    alike = ", or a wheel spins that is not in the file" + (
        ", or tachometers are off" if read else ""
    )
    for wheel, h in zip(problem.robot.wheels, _momenta(problem), strict=True):
        across = across_of(wheel.axis)
        hidden = alike if _steady(h) else ""

        def words(c: Numbers, name: str = wheel.name, hidden: str = hidden) -> str:
            angle = np.degrees(np.linalg.norm(c))
            axis = f"the axis of wheel {name} in the robot file"
            return f"{axis} is tilted by {angle:.2g} deg{hidden}"

        def turned(
            c: Numbers, h: Momentum = h, across: np.ndarray = across
        ) -> Momentum:
            return Rotation.from_rotvec(c @ across).apply(h) - h

        yield _with_momentum(words, np.full(2, SMALL), turned)


def _skewed_gyro() -> Suspect:
    """Axes of a gyro that are not at right angles: any small matrix but its scales."""
    off = ~np.eye(3, dtype=bool)

    def words(c: Numbers) -> str:
        return (
            "axes of the gyro are not at right angles (skewed), by up to "
            f"{1e3 * np.abs(c).max():.2g} mrad"
        )

    def corrected(problem: MomentumProblem, c: Numbers) -> MomentumProblem:
        M = np.eye(3)
        M[off] += c
        right = problem.recording.vector("gyro") @ M.T
        columns = of_vector("gyro", right)
        return replace(problem, recording=problem.recording.with_columns(columns))

    return Suspect(words, np.full(6, SMALL), corrected)


def _torque(problem: MomentumProblem, axes: Float[np.ndarray, "n 3"]) -> Suspect:
    """The robot's momentum in inertial axes grows by `c f(t)`: that of wheels falls."""
    by_power = _elapsed(problem)[:, None] ** np.array(POWERS)
    h = max(float(np.linalg.norm(np.nanmean(np.abs(_momenta(problem)), axis=1))), TINY)
    x = np.column_stack(problem.samples.x_WB)
    seen = np.isfinite(x).all(axis=1)
    R_BW = Rotation.from_quat(x[seen]).inv()

    def gained(c: Numbers) -> Float[np.ndarray, "powers 3"]:
        return h * np.reshape(c, (len(POWERS), -1)) @ axes

    def words(c: Numbers) -> str:
        T = float(np.ptp(problem.samples.t))
        size = np.linalg.norm(gained(c).sum(axis=0)) / T
        return (
            "an external torque that changes with time acts, by drag, friction or "
            f"another disturbance, of about {size:.1g} N m"
        )

    def lost(c: Numbers) -> Momentum:
        momentum = np.zeros((x.shape[0], 3))
        momentum[seen] = -R_BW.apply(by_power[seen] @ gained(c))
        return momentum

    return _with_momentum(words, np.full(len(POWERS) * len(axes), SMALL), lost)


def _with_momentum(
    words: Callable[[Numbers], str],
    small: Numbers,
    momentum: Callable[[Numbers], Momentum],
    most: float = np.inf,
) -> Suspect:
    """A momentum in base axes that the robot file or the wheels' speeds lack."""

    def corrected(problem: MomentumProblem, c: Numbers) -> MomentumProblem:
        robot, samples = problem.robot, problem.samples
        turning = list(robot.conserved_axes[0])
        speeds = tuple(np.ascontiguousarray(momentum(c)[:, turning].T) / LIGHT)
        wheels = [Wheel(f"{EXTRA}_{k}", np.eye(3)[k], LIGHT) for k in turning]
        columns = {
            f"wheel.{wheel.name}.speed": speed
            for wheel, speed in zip(wheels, speeds, strict=True)
        }
        return replace(
            problem,
            robot=replace(robot, wheels=(*robot.wheels, *wheels)),
            samples=replace(
                samples,
                qd_rw=(*samples.qd_rw, *speeds),
                speeds=(*samples.speeds, *len(wheels) * [NO_NOISE]),
            ),
            recording=problem.recording.with_columns(columns),
        )

    return Suspect(words, small, corrected, most)


def _elapsed(problem: MomentumProblem) -> Float[np.ndarray, " n"]:
    t = problem.samples.t
    return (t - t[0]) / (t[-1] - t[0])


def _momenta(problem: MomentumProblem) -> Float[np.ndarray, "wheels n 3"]:
    """The momentum of each wheel, base axes, N m s."""
    speeds = np.reshape(problem.samples.qd_rw, (-1, problem.samples.t.size))
    return np.einsum("kw,wn->wnk", wheels_of(problem.robot).A_rw, speeds)
