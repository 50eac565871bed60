"""Signs, degrees and order of joints and wheels."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations

from orbident.estimation.causes.convention import DEGREE, Convention, scaled
from orbident.estimation.problem import MomentumProblem
from orbident.preprocessing.samples import Samples
from orbident.robot.description import Robot


def of_joints(robot: Robot) -> Iterator[Convention]:
    """One joint, two, or all of them."""
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
        yield scaled(joint, -1.0, "the sign of all joints is the opposite")
        yield scaled(joint, DEGREE, "all joints are in degrees")
    yield from _exchanged("joint", names, joint)


def of_wheels(robot: Robot) -> Iterator[Convention]:
    """One wheel, two, or all of them."""
    names = robot.wheel_names
    wheel = ("qd_rw",)
    for k, name in enumerate(names):
        words = f"the sign of wheel {name}, or of its axis, is the opposite"
        yield _part_of("wheel", names, wheel, -1.0, words, [k])
    if len(names) > 1:
        yield scaled(wheel, -1.0, "the sign of all wheels is the opposite")
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
    return replace(scaled(columns, factor, cause, only), columns=recorded)


def _columns_of(kind: str, name: str) -> Iterator[str]:
    rate = "velocity" if kind == "joint" else "speed"
    return (f"{kind}.{name}.{what}" for what in ("position", rate))


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
