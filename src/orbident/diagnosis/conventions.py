"""Signs, units, orders, axes and zeros: all that people write differently.

Each is put right in the recording; or, to score it quickly, in the samples that were
derived from it, where no other samples depend on it.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations, permutations, product

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation, Slerp

from orbident.diagnosis.shifts import of_vector
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.output_error.sensors import COMPONENTS
from orbident.preprocessing.delays import corrections
from orbident.preprocessing.integrals import Turned, turned
from orbident.preprocessing.samples import Samples, samples_of
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot

DEGREE = np.pi / 180
RPM = 2 * np.pi / 60  # rad/s: a turn a minute

CLOSER = 2.0
"""Times that gyro and attitude must differ less with a convention put right."""

LARGER = 1.2
"""Times: a gyro's scale is known better than that, and so is a clock's rate."""

GRAVITY = 9.80665
"""m/s^2: of 1 g."""

FIELDS = {"joint": ("q", "qd"), "wheel": ("qd_rw",)}
"""Fields of `Samples` that hold joints and wheels."""
UNITS_OF_ANGLE: Mapping[str, Sequence[tuple[str, float]]] = {
    "joint": (("degrees", DEGREE),),
    "wheel": (("rpm", RPM), ("degrees", DEGREE)),
}
OF_POSITIONS = {"joint": "velocity", "wheel": "speed"}
"""Beside positions."""

Change = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Convention:
    """A cause of a misfit, and what undoes it."""

    cause: str
    """What is wrong, if it is this: a clause."""
    written: Callable[[MomentumProblem], Recording]
    """The recording with it put right."""
    quickly: Callable[[Samples], Samples] | None = None
    """The samples put right, where that is quicker than to derive them again."""

    def amended(self, problem: MomentumProblem) -> Samples:
        """The samples of a recording with it put right."""
        if self.quickly is not None:
            return self.quickly(problem.samples)
        right = self.written(problem)
        return samples_of(problem.robot, right, corrections(problem.clocks))


def scaled(names: Sequence[str], factor: float) -> Callable[[Samples], Samples]:
    """Samples of these names times a factor."""

    def right(samples: Samples) -> Samples:
        tables = {name: getattr(samples, name) for name in names}
        columns = {
            name: tuple(factor * column for column in table)
            for name, table in tables.items()
        }
        return replace(samples, **columns)

    return right


def of_all(kind: str, names: Sequence[str]) -> Iterator[Convention]:
    """One joint or wheel, two of them, or all."""
    every = dict.fromkeys(range(len(names)), -1.0)
    for k, name in enumerate(names):
        words = f"the sign of {kind} {name}, or of its axis, is the opposite"
        yield _written(words, kind, names, {k: -1.0})
        for unit, size in UNITS_OF_ANGLE[kind]:
            yield _written(f"{kind} {name} is in {unit}", kind, names, {k: size})
    for one, other in combinations(range(len(names)), 2):
        both = f"{kind}s {names[one]} and {names[other]}"
        words = f"the signs of {both}, or of their axes, are the opposite"
        if kind == "joint":
            yield _written(words, kind, names, {one: -1.0, other: -1.0})
        order = [{one: other, other: one}.get(k, k) for k in every]
        yield _written(f"{both} are exchanged", kind, names, {}, order)
    if len(names) > 1:
        words = f"the sign of all {kind}s is the opposite"
        yield _written(words, kind, names, every)
        for unit, size in UNITS_OF_ANGLE[kind]:
            sizes = {k: size for k in every}
            yield _written(f"all {kind}s are in {unit}", kind, names, sizes)


def _written(
    cause: str,
    kind: str,
    names: Sequence[str],
    factors: Mapping[int, float],
    order: Sequence[int] | None = None,
) -> Convention:
    """Some of the joints or wheels times a factor, or in another order."""
    order = order or range(len(names))

    def quickly(samples: Samples) -> Samples:
        return replace(
            samples,
            **{
                name: tuple(
                    factors.get(k, 1.0) * getattr(samples, name)[source]
                    for k, source in enumerate(order)
                )
                for name in FIELDS[kind]
            },
        )

    def written(problem: MomentumProblem) -> Recording:
        columns = problem.recording.columns
        right = {
            f"{kind}.{names[k]}.{what}": factors.get(k, 1.0)
            * columns[f"{kind}.{names[source]}.{what}"]
            for k, source in enumerate(order)
            for what in ("position", OF_POSITIONS[kind])
            if f"{kind}.{names[source]}.{what}" in columns
        }
        return problem.recording.with_columns(right)

    return Convention(cause, written, quickly)


def _other_zeros(robot: Robot) -> Iterator[Convention]:
    """Joints whose zero is a quarter or half a turn away, as another drawing has it.

    Of many arms a recording does not show a half turn, so which way is not said.
    """
    for k, joint in enumerate(robot.joints):
        if joint.name in robot.passive or joint.kind == "prismatic":
            continue
        for turn in (90, -90, 180):
            part = "half" if turn == 180 else "a quarter of"
            words = f"the zero of joint {joint.name} is {part} a turn off"
            yield _of_zero(words, k, joint.name, np.radians(turn))


def _of_zero(cause: str, joint: int, name: str, off: float) -> Convention:
    column = f"joint.{name}.position"

    def quickly(samples: Samples) -> Samples:
        q = list(samples.q)
        q[joint] = q[joint] - off
        return replace(samples, q=tuple(q))

    def written(problem: MomentumProblem) -> Recording:
        right = {column: problem.recording.column(column) - off}
        return problem.recording.with_columns(right)

    return Convention(cause, written, quickly)


UNITS_OF_LENGTH = (("mm", 1e-3), ("cm", 1e-2))
UNITS_OF_TIME = (("ms (milliseconds)", 1e-3), ("minutes", 60.0))

CONJUGATE = np.array([-1.0, -1.0, -1.0, 1.0])

Matrix = Float[np.ndarray, "3 3"]
Vectors = Float[np.ndarray, "n 3"]


def conventions(problem: MomentumProblem) -> Iterator[Convention]:
    """Everything that may have been written differently, one at a time."""
    robot, recording = problem.robot, problem.recording
    yield from of_all("joint", robot.joint_names)
    yield from of_all("wheel", robot.wheel_names)
    yield from _other_zeros(robot)
    turning = {"gyro": _gyro(robot, problem), "attitude": _attitude(robot)}
    shown = {one: each for one, each in turning.items() if recording.has(f"{one}.x")}
    if len(shown) > 1:
        shown = {one: _reconciling(problem, each) for one, each in shown.items()}
    yield from shown.get("gyro", ())
    point = "velocity" if recording.has("velocity.x") else "position"
    if problem.samples.v_S:
        yield from _turned(robot, point, "v_S")
        for unit, size in UNITS_OF_LENGTH:
            words = f"the {point} is in {unit}"
            yield _times(point, size, words, scaled(("v_S",), size))
    if recording.has("velocity.x", "attitude.x"):
        in_base = "the velocity is in base axes, not in inertial ones"
        yield _by_attitude("velocity", in_base, lambda R_WB, v: R_WB.apply(v))
    yield from shown.get("attitude", ())
    for unit, size in UNITS_OF_TIME:
        cause = f"the time is in {unit}, not in s"
        yield Convention(cause, partial(_slower, size=size))


def felt_alone(problem: MomentumProblem) -> MomentumProblem | None:
    """The problem without other sensors of the motion of S than an accelerometer.

    Beside these the linear equations do not use it. None without an accelerometer.
    """
    recording = problem.recording
    if not recording.has("accelerometer.x"):
        return None
    others = ("position.", "velocity.")
    columns = {
        name: x for name, x in recording.columns.items() if not name.startswith(others)
    }
    if len(columns) == len(recording.columns):
        return problem
    return problem.amended(recording=replace(recording, columns=columns))


def of_accelerometer() -> Convention:
    """What it may show in another unit."""
    in_g = "the accelerometer is in g, and not in m/s^2"
    return _times("accelerometer", GRAVITY, in_g)


def _slower(problem: MomentumProblem, size: float) -> Recording:
    return replace(problem.recording, t=size * problem.recording.t)


def _gyro(robot: Robot, problem: MomentumProblem) -> Iterator[Convention]:
    # An attitude is fused with the gyro: all is derived again, but of a single one.
    attitude = np.isfinite(problem.recording.columns.get("attitude.x", [])).sum() > 1
    for one in _turned(robot, "gyro", "w"):
        yield replace(one, quickly=None) if attitude else one
    yield _times("gyro", DEGREE, "the gyro is in degrees per second")
    if attitude:
        inertial = "the gyro is in inertial axes, not in the base's"
        yield _by_attitude("gyro", inertial, lambda R_WB, w: R_WB.inv().apply(w))
        euler = "the gyro shows rates of Euler angles (roll, pitch and yaw)"
        yield _by_attitude("gyro", euler, _from_euler_rates)
        yield from _by_ratio(problem)


def _reconciling(
    problem: MomentumProblem, each: Iterable[Convention]
) -> Iterator[Convention]:
    """Those of gyro or attitude with which the two differ far less.

    Where they agree as they were recorded there are none: each shows that the other is
    written as it should be.
    """
    recorded = turned_in(problem.recording).apart
    for one in each:
        if not recorded <= CLOSER * turned_in(one.written(problem)).apart:
            yield one


def turned_in(recording: Recording) -> Turned:
    """How the base turned in a recording by its gyro, and by its attitude."""
    attitude = recording.vector("attitude", COMPONENTS["attitude"])
    return turned(recording.t, recording.vector("gyro"), attitude)


def _by_ratio(problem: MomentumProblem) -> Iterator[Convention]:
    """A gyro, or times, by as many times too large as the attitude shows."""
    ratio = turned_in(problem.recording).ratio
    if max(ratio, 1 / ratio if ratio > 0 else 0.0) < LARGER:
        return
    # Which of both it is, residuals hardly say.
    cause = (
        f"the gyro turns the base {ratio:.3g} times as far as the attitude does, so "
        "that its unit, or that of the times, is another one"
    )
    yield _times("gyro", 1 / ratio, cause)
    yield Convention(cause, partial(_slower, size=1 / ratio))


def _turned(robot: Robot, name: str, vector: str) -> Iterator[Convention]:
    for words, R in _other_axes(robot):
        what = words if words.startswith("the sign") else f"the axes ({words})"
        # A rotation of the position is one of the inertial axes the other way round.
        inertial = vector == "v_S" and np.linalg.det(R) > 0
        of = f"{name}, or the inertial axes of the attitude," if inertial else name
        one = what.startswith("the sign of") and not inertial
        verb = "differs" if one else "differ"
        yield Convention(
            f"{what} of the {of} {verb}",
            _changed(name, lambda x, R=R: x @ R.T),
            lambda samples, R=R: replace(
                samples, **{vector: tuple(R @ np.array(getattr(samples, vector)))}
            ),
        )


def _attitude(robot: Robot) -> Iterator[Convention]:
    def quaternion(words: str, change: Change) -> Convention:
        cause = f"the quaternion of the attitude is {words}"
        return Convention(cause, _changed("attitude", change))

    yield quaternion("the inverse, from inertial to base axes", lambda x: CONJUGATE * x)
    # In a plane such an attitude does not turn about z, and screening refuses it.
    if robot.motion == "spatial":
        yield quaternion("scalar first", lambda x: np.roll(x, -1, axis=1))
        yield quaternion(
            "scalar first, and the inverse",
            lambda x: CONJUGATE * np.roll(x, -1, axis=1),
        )
    for words, R in _other_axes(robot):
        if np.linalg.det(R) < 0:
            continue
        R_BS = Rotation.from_matrix(R)
        yield Convention(
            f"the attitude sensor is turned in the base: {words}",
            _changed(
                "attitude",
                lambda x, R_BS=R_BS: (Rotation.from_quat(x) * R_BS).as_quat(),
            ),
        )


def _other_axes(robot: Robot) -> Iterator[tuple[str, Matrix]]:
    """All ways to call the axes: what was recorded as x is the first, signs and all."""
    for order in permutations(range(3)):
        for signs in product((1, -1), repeat=3):
            R = np.zeros((3, 3))
            R[range(3), order] = signs
            if robot.motion == "planar" and R[2, 2] != 1:
                continue
            flipped = [k for k, sign in zip("xyz", signs, strict=True) if sign < 0]
            if order != (0, 1, 2):
                used = (
                    "-" * (s < 0) + "xyz"[k] for s, k in zip(signs, order, strict=True)
                )
                yield f"the order: x, y, z are its {', '.join(used)}", R
            elif len(flipped) == 3:
                yield "the signs", R
            elif flipped:
                signs_of = "the sign of" if len(flipped) == 1 else "the signs of"
                yield f"{signs_of} {' and '.join(flipped)}", R


def _times(
    sensor: str,
    factor: float,
    cause: str,
    quickly: Callable[[Samples], Samples] | None = None,
) -> Convention:
    """A sensor's samples times a factor."""
    return Convention(cause, _changed(sensor, lambda x: factor * x), quickly)


def _changed(sensor: str, change: Change) -> Callable[[MomentumProblem], Recording]:
    """What a sensor of the base showed, changed."""

    def written(problem: MomentumProblem) -> Recording:
        recording = problem.recording
        x = recording.vector(sensor, COMPONENTS[sensor]).copy()
        seen = np.isfinite(x).all(axis=1)
        x[seen] = change(x[seen])
        return recording.with_columns(of_vector(sensor, x))

    return written


def _by_attitude(
    sensor: str, cause: str, change: Callable[[Rotation, Vectors], Vectors]
) -> Convention:
    """A sensor's samples, changed by the attitude that was recorded."""

    def written(problem: MomentumProblem) -> Recording:
        t, shown = problem.recording.t, problem.recording.vector(sensor)
        x = problem.recording.vector("attitude", COMPONENTS["attitude"])
        known = np.isfinite(x).all(axis=1)
        attitude = Slerp(t[known], Rotation.from_quat(x[known]))
        first, last = t[known][[0, -1]]
        seen = np.isfinite(shown).all(axis=1) & (t >= first) & (t <= last)
        right = np.full_like(shown, np.nan)
        right[seen] = change(attitude(t[seen]), shown[seen])
        return problem.recording.with_columns(of_vector(sensor, right))

    return Convention(cause, written)


def _from_euler_rates(R_WB: Rotation, rates: Vectors) -> Vectors:
    """The rates of the base whose roll, pitch and yaw change at these rates.

    The base turns by yaw about `z`, then by pitch about `y`, then by roll about `x`.
    """
    _, pitch, roll = R_WB.as_euler("ZYX").T
    p, q, r = rates.T
    across = r * np.cos(pitch)
    return np.column_stack(
        [
            p - r * np.sin(pitch),
            q * np.cos(roll) + across * np.sin(roll),
            across * np.cos(roll) - q * np.sin(roll),
        ]
    )
