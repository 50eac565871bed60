"""What was captured, or let go: two results of one robot, before and after."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from orbident.errors import InputError
from orbident.estimation.levels import ChiSquare
from orbident.estimation.parameter_checks import VAGUE
from orbident.estimation.result import Result
from orbident.files.names import joined, suggestion
from orbident.identified.difference import (
    Difference,
    change_of_pi,
    check_same_robot,
    determined_combinations,
    difference_of,
)
from orbident.identified.single_body import (
    AddedBody,
    Explanation,
    added_body,
    explanations,
    free_columns,
)
from orbident.robot.description import Robot
from orbident.robot.parameters import PER_BODY, SYMBOLS, Structure


@dataclass(frozen=True, repr=False)
class Comparison:
    """What changed between two results."""

    status: Literal["changed", "no change", "rejected"]
    """`"rejected"` if one of the results is."""
    warnings: tuple[str, ...]
    """What a person should know of it, in sentences."""
    change: ChiSquare | None = None
    """Chi-square of the difference; None for rejected results."""
    of: Literal["base parameters", "pi"] = "base parameters"
    """What is compared: `pi` where a result has nothing else."""
    explanations: tuple[Explanation, ...] = ()
    """Explanations by one body that joined another, the most probable first."""
    body: str | None = None
    """What the captured body is attached to; None where there is none."""
    added: AddedBody | None = None
    undetermined: Mapping[str, str] = field(default_factory=dict)
    """Parameters of the captured body, and why they are not determined."""

    def __repr__(self) -> str:
        """Whether something changed, and the mass of what joined."""
        if self.change is None:
            return f"{self.status}: {'; '.join(self.warnings)}"
        chi2, dof, p = self.change.value, self.change.dof, self.change.p
        lines = [
            f"{self.status}: {self.of} differ by chi-square {chi2:.4g}, expected {dof} "
            f"(p {p:.2g})"
        ]
        if self.added is not None:
            did = "let go by" if self.added.mass.value < 0 else "captured by"
            lines.append(f"{did} {self.body}: mass {self.added.mass} kg; see .added")
        return "\n".join([*lines, *self.warnings])

    def to_json(self) -> dict[str, Any]:
        """As `compare --json` gives it."""
        return {
            "status": self.status,
            "warnings": list(self.warnings),
            "change": None if self.change is None else self.change.to_json(),
            "of": self.of,
            "body": self.body,
            "explanations": [
                {"body": e.body, **e.left.to_json(), "probability": e.probability}
                for e in self.explanations
            ],
            "added": None if self.added is None else self.added.to_json(),
            "undetermined": dict(self.undetermined),
        }


def compare(before: Result, after: Result, body: str | None = None) -> Comparison:
    """What a robot captured, or let go, between two recordings.

    Args:
        before: the result from the one.
        after: from the other, which is independent of it.
        body: by name, what holds it; by default what explains the difference best.

    Returns:
        Whether the parameters changed by more than chance, and the body that explains
        it.

    Raises:
        InputError: the robots differ, their structures contradict each other, or they
            have no such body.
    """
    check_same_robot(before.robot, after.robot)
    bodies = after.robot.bodies
    if body is not None and body not in bodies:
        raise InputError(f"no body '{body}'; {suggestion(body, bodies, 'bodies')}")
    untrusted = rejected(before, after)
    if untrusted:
        return Comparison("rejected", untrusted)
    if before.of_momentum_alone or after.of_momentum_alone:
        return _of_momentum(before, after)
    return _compared(before, after, body)


def _of_momentum(before: Result, after: Result) -> Comparison:
    """Whether `pi` is another, where that is all that one of the results has."""
    change = change_of_pi(before, after)
    status, words = (
        "no change",
        "pi is compared, as a result has nothing else: robots that differ in their "
        "masses may have one pi; record positions, too, to tell them apart",
    )
    if change.is_no_chance("comparison"):
        status, words = (
            "changed",
            "pi alone does not say what was captured or let go; record positions "
            "before and after",
        )
    return Comparison(status, (*optimistic(before, after), words), change, of="pi")


def _compared(before: Result, after: Result, body: str | None) -> Comparison:
    warnings = optimistic(before, after)
    difference = difference_of(before, after)
    # Only noise where nothing changed.
    white = difference.W @ difference.d
    change = ChiSquare(float(np.sum(white**2)), white.size)
    if change.dof and not change.is_no_chance("comparison"):
        return Comparison("no change", warnings, change)
    # What holds it, and with what structure: the total mass tells.
    released = bool(before.base.values[0] > after.base.values[0])
    holder = before.robot if released else after.robot
    found = explanations(difference, holder)
    best = next(e for e in found if body in {None, e.body})
    useless = None
    if np.isnan(best.theta).all():
        useless = f"nothing that changed is determined: {lost(before, after)}"
    elif best.left.is_no_chance("comparison"):
        useless = unexplained(best, found)
    if useless:
        return Comparison("rejected", (*warnings, useless), change, explanations=found)
    added = added_body(best.theta, best.covariance)
    warnings += others(best, found) if body is None else ()
    return Comparison(
        status="changed",
        warnings=warnings + doubts(best, holder, added),
        change=change,
        explanations=found,
        body=best.body,
        added=added,
        undetermined=undetermined(best, difference, holder, before, after),
    )


POSSIBLE = 0.05
"""A body of this probability is worth a word."""
WHITE = "least-squares"
"""The method whose covariance knows no bias, and nothing that sensors integrate."""


def rejected(before: Result, after: Result) -> tuple[str, ...]:
    """Which of two results must not be trusted."""
    return tuple(
        f"the run {when} is refused, so nothing is compared: " + result.refusal()
        for when, result in (("before", before), ("after", after))
        if result.status == "rejected"
    )


def optimistic(before: Result, after: Result) -> tuple[str, ...]:
    """Which results have deviations that are too small."""
    return tuple(
        f"the run {when} is by {result.method}, which takes the noise for white: its "
        "deviations are too small, so that chance looks like a change; identify again "
        "by maximum-likelihood"
        for when, result in (("before", before), ("after", after))
        if result.method == WHITE
    )


def unexplained(best: Explanation, found: tuple[Explanation, ...]) -> str:
    """No single body: what to look for."""
    how = f"chi-square {best.left.value:.4g}, expected {best.left.dof}"
    if found[0].left.p > best.left.p and found[0].body != best.body:
        return (
            f"a body on '{best.body}' does not explain the change ({how}); one on "
            f"'{found[0].body}' does better"
        )
    return (
        f"no single body explains the change: the best, on '{best.body}', leaves "
        f"{how}; did more than one thing change, does the structure of the body that "
        "holds it still hold, do both runs fit their recordings?"
    )


def others(best: Explanation, found: tuple[Explanation, ...]) -> tuple[str, ...]:
    """Bodies that explain the difference about as well, if any does."""
    close = [e for e in found if e.body != best.body and e.probability > POSSIBLE]
    if not close:
        return ()
    listed = ", ".join(f"'{e.body}' ({e.probability:.2g})" for e in close)
    return (
        f"it is on '{best.body}' with probability {best.probability:.2g} only, and may "
        f"be on {listed}; name the body if it is known",
    )


def doubts(best: Explanation, holder: Robot, added: AddedBody) -> tuple[str, ...]:
    """What makes the numbers doubtful, or some of them impossible to give."""
    words = []
    zero = holder.structure.get(best.body, Structure()).zero_parameters()
    if zero:
        names = ", ".join(symbol for symbol in SYMBOLS if symbol in zero)
        words.append(
            f"'{best.body}' with what it holds is taken to have no {names} (its "
            "structure); identify again without, unless this is known"
        )
    if added.mass.std >= VAGUE * abs(added.mass.value):
        words.append(
            f"the mass, {added.mass.value:.3g} +- {added.mass.std:.2g} kg, is too "
            "vague to determine the CM and the inertia about it"
        )
    if added.impossible:
        words.append(f"no body is like this: {added.impossible}")
    return tuple(words)


def lost(before: Result, after: Result) -> str:
    """What the results do not determine."""
    parts = []
    for when, result in (("before", before), ("after", after)):
        unknown = np.flatnonzero(~np.isfinite(result.base.values))
        names = [result.base.names[k] for k in unknown]
        if names:
            parts.append(f"the run {when} does not determine {joined(names)}")
    return " and ".join(parts)


def undetermined(
    best: Explanation,
    difference: Difference,
    holder: Robot,
    before: Result,
    after: Result,
) -> dict[str, str]:
    """Why, for every parameter of the captured body that is not determined."""
    i = holder.bodies.index(best.body)
    free = free_columns(holder, i)
    _, alone = determined_combinations(difference.T_c[:, PER_BODY * i + free])
    plane = " of planar motion" if holder.motion == "planar" else ""
    reasons = {}
    for k in np.flatnonzero(np.isnan(best.theta)):
        if k not in free:
            reason = f"the structure of '{best.body}' takes it as zero"
        elif k not in free[alone]:
            reason = f"does not show in the momentum{plane}"
        else:
            reason = lost(before, after)
        reasons[SYMBOLS[k]] = reason
    return reasons
