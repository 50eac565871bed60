"""Ways to write what others write differently: signs, degrees, order of columns."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations

import numpy as np

from orbident.estimation.momentum_problem import MomentumProblem
from orbident.preprocessing.samples import Samples
from orbident.recordings.recording import Recording

DEGREE = np.pi / 180


FIELDS = {"joint": ("q", "qd"), "wheel": ("qd_rw",)}
"""Fields of `Samples` that hold joints and wheels."""
RATES = {"joint": "velocity", "wheel": "speed"}
"""Beside positions."""


@dataclass(frozen=True)
class Convention:
    """A cause of a misfit, and what undoes it."""

    cause: str
    """What is wrong, if it is this: a clause."""
    amended: Callable[[MomentumProblem], Samples]
    columns: Mapping[str, tuple[str, float]] = field(default_factory=dict)
    """The column that replaces a joint or wheel column, and a factor, by its name."""

    def recording(self, recording: Recording) -> Recording:
        """The recording with its columns put right."""
        right = {
            name: factor * recording.columns[source]
            for name, (source, factor) in self.columns.items()
            if recording.has(source)
        }
        return recording.with_columns(right)


def scaled(names: Sequence[str], factor: float, cause: str) -> Convention:
    """Samples of these names times a factor."""

    def amended(problem: MomentumProblem) -> Samples:
        tables = {name: getattr(problem.samples, name) for name in names}
        columns = {
            name: tuple(factor * column for column in table)
            for name, table in tables.items()
        }
        return replace(problem.samples, **columns)

    return Convention(cause, amended)


def of_all(kind: str, names: Sequence[str]) -> Iterator[Convention]:
    """One joint or wheel, two of them, or all."""
    every = dict.fromkeys(range(len(names)), -1.0)
    for k, name in enumerate(names):
        words = f"the sign of {kind} {name}, or of its axis, is the opposite"
        yield _written(words, kind, names, {k: -1.0})
        if kind == "joint" or len(names) > 1:
            degrees = {k: DEGREE}
            yield _written(f"{kind} {name} is in degrees", kind, names, degrees)
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
        if kind == "joint":
            degrees = dict.fromkeys(every, DEGREE)
            yield _written("all joints are in degrees", kind, names, degrees)


def _written(
    cause: str,
    kind: str,
    names: Sequence[str],
    factors: Mapping[int, float],
    order: Sequence[int] | None = None,
) -> Convention:
    """Some of the joints or wheels times a factor, or in another order."""
    order = order or range(len(names))

    def amended(problem: MomentumProblem) -> Samples:
        samples = problem.samples
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

    columns = {
        f"{kind}.{names[k]}.{what}": (
            f"{kind}.{names[source]}.{what}",
            factors.get(k, 1.0),
        )
        for k, source in enumerate(order)
        for what in ("position", RATES[kind])
        if source != k or k in factors
    }
    return Convention(cause, amended, columns)
