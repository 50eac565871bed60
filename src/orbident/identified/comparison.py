"""What was captured, or let go: two results of one robot, before and after."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from orbident.errors import InputError
from orbident.estimation.result import Result
from orbident.files.names import suggestion
from orbident.identified import reasons
from orbident.identified.added_body import AddedBody, added_body
from orbident.identified.difference import difference_of
from orbident.identified.same_robot import check_same_robot
from orbident.identified.single_body import (
    ChiSquare,
    Explanation,
    explanations,
    total,
)

CHANCE = 1e-3
"""What is less probable than this is no chance."""


@dataclass(frozen=True, repr=False)
class Comparison:
    """What changed between two results."""

    status: Literal["changed", "no change", "rejected"]
    """`"rejected"` if one of the results is."""
    warnings: tuple[str, ...]
    """What a person should know of it, in sentences."""
    change: ChiSquare | None = None
    """Chi-square of the base parameters' difference; None for rejected results."""
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
            f"{self.status}: the base parameters differ by chi-square {chi2:.4g}, "
            f"expected {dof} (p {p:.2g})"
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
    untrusted = reasons.rejected(before, after)
    if untrusted:
        return Comparison("rejected", untrusted)
    return _compared(before, after, body)


def _compared(before: Result, after: Result, body: str | None) -> Comparison:
    warnings = reasons.optimistic(before, after)
    difference = difference_of(before, after)
    change = total(difference)
    if change.dof and change.p > CHANCE:
        return Comparison("no change", warnings, change)
    # What holds it, and with what structure: the total mass tells.
    released = bool(before.base.values[0] > after.base.values[0])
    holder = before.robot if released else after.robot
    found = explanations(difference, holder)
    best = next(e for e in found if body in {None, e.body})
    useless = None
    if np.isnan(best.theta).all():
        useless = f"nothing that changed is determined: {reasons.lost(before, after)}"
    elif best.left.p < CHANCE:
        useless = reasons.unexplained(best, found)
    if useless:
        return Comparison("rejected", (*warnings, useless), change, found)
    added = added_body(best.theta, best.covariance)
    warnings += reasons.others(best, found) if body is None else ()
    return Comparison(
        status="changed",
        warnings=warnings + reasons.doubts(best, holder, added),
        change=change,
        explanations=found,
        body=best.body,
        added=added,
        undetermined=reasons.undetermined(best, difference, holder, before, after),
    )
