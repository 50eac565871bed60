"""Signs, units, orders and axes: all that people write differently.

What is put right is the samples that were derived from a recording, but for the
attitude, which gyro and base rate are fused with.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations, permutations, product

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from orbident.estimation.problem import MomentumProblem
from orbident.preprocessing.delays import corrections
from orbident.preprocessing.samples import Samples, samples_of
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot


@dataclass(frozen=True)
class Convention:
    """A cause of a misfit, and what undoes it."""

    cause: str
    """What is wrong, if it is this: a clause."""
    amended: Callable[[MomentumProblem], Samples]
    columns: Mapping[str, tuple[str, float]] = field(default_factory=dict)
    """Of joints or wheels: from which other column a column is to be, times what."""

    def recording(self, recording: Recording) -> Recording:
        """With its columns put right."""
        right = {
            name: factor * recording.columns[source]
            for name, (source, factor) in self.columns.items()
            if recording.has(source)
        }
        return replace(recording, columns={**recording.columns, **right})


DEGREE = np.pi / 180

UNITS_OF_LENGTH = (("mm", 1e-3), ("cm", 1e-2))
UNITS_OF_TIME = (("ms (milliseconds)", 1e-3), ("minutes", 60.0))

CONJUGATE = np.array([-1.0, -1.0, -1.0, 1.0])

Matrix = Float[np.ndarray, "3 3"]
Change = Callable[[np.ndarray], np.ndarray]


def conventions(problem: MomentumProblem) -> Iterator[Convention]:
    """Everything that may have been written differently, one at a time."""
    robot, recording = problem.robot, problem.recording
    yield from _joints(robot)
    yield from _wheels(robot)
    if recording.has("gyro.x"):
        yield from _vector(robot, "gyro", "w")
        yield _scaled(("w",), DEGREE, "the gyro is in degrees per second")
        yield Convention("the gyro is in inertial axes, not in the base's", _to_base)
    point = "position" if recording.has("position.x") else "velocity"
    if problem.samples.v_S:
        yield from _vector(robot, point, "v_S")
        for unit, size in UNITS_OF_LENGTH:
            yield _scaled(("v_S",), size, f"the {point} is in {unit}")
    if recording.has("attitude.x"):
        yield from _attitude(robot)
    for unit, size in UNITS_OF_TIME:
        cause = f"the time is in {unit}, not in s"
        yield _scaled(_rates(problem), 1 / size, cause)


def _joints(robot: Robot) -> Iterator[Convention]:
    names = robot.joint_names
    joint = "q", "qd"
    for k, name in enumerate(names):
        words = f"the sign of joint {name}, or of its axis, is the opposite"
        yield _part_of("joint", names, joint, -1.0, words, [k])
        words = f"joint {name} is in degrees"
        yield _part_of("joint", names, joint, DEGREE, words, [k])
    for one, other in combinations(range(len(names)), 2):
        words = (
            f"the signs of joints {names[one]} and {names[other]}, or of their axes, "
            "are the opposite"
        )
        yield _part_of("joint", names, joint, -1.0, words, [one, other])
    if len(names) > 1:
        yield _scaled(joint, -1.0, "the sign of all joints is the opposite")
        yield _scaled(joint, DEGREE, "all joints are in degrees")
    yield from _exchanged("joint", names, joint)


def _wheels(robot: Robot) -> Iterator[Convention]:
    names = robot.wheel_names
    wheel = ("qd_rw",)
    for k, name in enumerate(names):
        words = f"the sign of wheel {name}, or of its axis, is the opposite"
        yield _part_of("wheel", names, wheel, -1.0, words, [k])
    if len(names) > 1:
        yield _scaled(wheel, -1.0, "the sign of all wheels is the opposite")
        for k, name in enumerate(names):
            words = f"wheel {name} is in degrees"
            yield _part_of("wheel", names, wheel, DEGREE, words, [k])
    yield from _exchanged("wheel", names, wheel)


def _part_of(
    kind: str,
    names: Sequence[str],
    columns: Sequence[str],
    factor: float,
    cause: str,
    only: Sequence[int],
) -> Convention:
    """Some of the joints or wheels."""
    recorded = {
        column: (column, factor) for k in only for column in _columns_of(kind, names[k])
    }
    return replace(_scaled(columns, factor, cause, only), columns=recorded)


def _columns_of(kind: str, name: str) -> Iterator[str]:
    rate = "velocity" if kind == "joint" else "speed"
    return (f"{kind}.{name}.{what}" for what in ("position", rate))


def _vector(robot: Robot, name: str, vector: str) -> Iterator[Convention]:
    for words, R in _other_axes(robot):
        what = "the signs" if words == "sign" else f"the axes ({words})"
        # A rotation of the position is one of the inertial axes the other way round.
        inertial = vector == "v_S" and np.linalg.det(R) > 0
        of = f"{name}, or the inertial axes of the attitude" if inertial else name
        yield Convention(f"{what} of the {of} differ", _turned(vector, R))


def _attitude(robot: Robot) -> Iterator[Convention]:
    def quaternion(words: str, change: Change) -> Convention:
        return Convention(
            f"the quaternion of the attitude is {words}", _quaternion(change)
        )

    yield quaternion("scalar first", lambda x: np.roll(x, -1, axis=1))
    yield quaternion("the inverse, from inertial to base axes", lambda x: CONJUGATE * x)
    yield quaternion(
        "scalar first, and the inverse",
        lambda x: CONJUGATE * np.roll(x, -1, axis=1),
    )
    for words, R in _other_axes(robot):
        if np.linalg.det(R) < 0:
            continue
        turn = Rotation.from_matrix(R)
        yield Convention(
            f"the attitude sensor is turned in the base: {words}",
            _quaternion(lambda x, turn=turn: _known(x, lambda q: q * turn)),
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
                yield "sign", R
            elif flipped:
                yield f"the sign of {' and '.join(flipped)}", R


def _rates(problem: MomentumProblem) -> tuple[str, ...]:
    """What was derived from positions and angles."""
    gyro = problem.recording.has("gyro.x")
    velocity = problem.recording.has("velocity.x")
    return "qd", "qd_rw", *(() if gyro else ("w",)), *(() if velocity else ("v_S",))


def _scaled(
    names: Sequence[str], factor: float, cause: str, only: Sequence[int] = ()
) -> Convention:
    def amended(problem: MomentumProblem) -> Samples:
        samples = problem.samples
        columns = {
            name: tuple(
                factor * column if not only or k in only else column
                for k, column in enumerate(getattr(samples, name))
            )
            for name in names
        }
        return replace(samples, **columns)

    return Convention(cause, amended)


def _exchanged(
    kind: str, names: Sequence[str], columns: Sequence[str]
) -> Iterator[Convention]:
    for one, other in combinations(range(len(names)), 2):
        order = list(range(len(names)))
        order[one], order[other] = other, one

        def amended(problem: MomentumProblem, order: list[int] = order) -> Samples:
            samples = problem.samples
            changed = {
                name: tuple(getattr(samples, name)[k] for k in order)
                for name in columns
            }
            return replace(samples, **changed)

        words = f"{kind} {names[one]} and {kind} {names[other]} are exchanged"
        recorded = {
            column: (source, 1.0)
            for a, b in ((one, other), (other, one))
            for column, source in zip(
                _columns_of(kind, names[a]), _columns_of(kind, names[b]), strict=True
            )
        }
        yield Convention(words, amended, recorded)


def _turned(vector: str, R: Matrix) -> Callable[[MomentumProblem], Samples]:
    def amended(problem: MomentumProblem) -> Samples:
        turned = R @ np.array(getattr(problem.samples, vector))
        return replace(problem.samples, **{vector: tuple(turned)})

    return amended


def _quaternion(change: Change) -> Callable[[MomentumProblem], Samples]:
    def amended(problem: MomentumProblem) -> Samples:
        recording = problem.recording
        x = change(recording.vector("attitude", "xyzw"))
        columns = {
            f"attitude.{k}": np.ascontiguousarray(values)
            for k, values in zip("xyzw", x.T, strict=True)
        }
        written = replace(recording, columns={**recording.columns, **columns})
        return samples_of(problem.robot, written, corrections(problem.clocks))

    return amended


def _known(x: np.ndarray, change: Callable[[Rotation], Rotation]) -> np.ndarray:
    """Where there is a sample."""
    seen, changed = np.isfinite(x).all(axis=1), x.copy()
    changed[seen] = change(Rotation.from_quat(x[seen])).as_quat()
    return changed


def _to_base(problem: MomentumProblem) -> Samples:
    x = problem.recording.vector("attitude", "xyzw")
    w = np.column_stack(problem.samples.w)
    seen = np.isfinite(x).all(axis=1) & np.isfinite(w).all(axis=1)
    turned = np.full_like(w, np.nan)
    turned[seen] = Rotation.from_quat(x[seen]).inv().apply(w[seen])
    return replace(problem.samples, w=tuple(np.ascontiguousarray(turned.T)))
