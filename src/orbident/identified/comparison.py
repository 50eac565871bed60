"""What was captured, or let go: two results of one robot, before and after.

Mass, CM and inertia of what joined follow from ten parameters. Not every inertia is
that of a body, within what is known of it.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

import numpy as np
from jaxtyping import Float, Inexact

from orbident.errors import InputError
from orbident.estimation.levels import ChiSquare
from orbident.estimation.parameter_checks import VAGUE
from orbident.estimation.quantities import Parameters, Quantity
from orbident.estimation.result import Result
from orbident.files.json_parts import nulled
from orbident.files.names import suggestion
from orbident.gaussian import NINETY_FIVE
from orbident.identified.difference import (
    Explanation,
    check_same_robot,
    difference_of,
    explanations,
    lost,
    total,
    undetermined,
)
from orbident.robot.description import Robot, Structure
from orbident.robot.parameters import (
    FIRST_MOMENT,
    INERTIA,
    INERTIA_ENTRIES,
    MASS,
    PER_BODY,
    SYMBOLS,
    inertia_matrix,
)

STEP = 1e-30
"""Imaginary: so small that the derivative of a rational function is exact."""
I_COM = (
    "Ixx - (my^2 + mz^2)/m",
    "Ixy + mx my/m",
    "Iyy - (mx^2 + mz^2)/m",
    "Ixz + mx mz/m",
    "Iyz + my mz/m",
    "Izz - (mx^2 + my^2)/m",
)


class AddedBody(NamedTuple):
    """What joined a body of the robot, in that body's frame; NaN: not determined.

    Of what left, mass and inertia are negative.
    """

    theta: Float[np.ndarray, "10"]
    """The ten parameters, in the order of `robot.parameters`."""
    covariance: Float[np.ndarray, "10 10"]
    mass: Quantity
    """kg."""
    com: Parameters
    """Position of its CM from the origin of the body's frame, m."""
    I_com: Parameters
    """About its own CM, kg m^2."""
    I_origin: Parameters
    """About the origin of the body's frame, kg m^2."""
    impossible: str | None
    """Why no body can be like this, its covariance considered; None where one can."""

    def to_json(self) -> dict[str, Any]:
        """The body with 95 % intervals and the covariance of its ten parameters."""
        sets = {
            "com": self.com,
            "inertia_about_com": self.I_com,
            "inertia_about_origin": self.I_origin,
        }
        return {
            "mass": {
                "value": nulled(self.mass.value),
                "std": nulled(self.mass.std),
                "interval": nulled(interval_95(self.mass.value, self.mass.std)),
            },
            **{
                name: {
                    **found.to_json(),
                    "intervals": [
                        nulled(interval_95(value, std)) for _, _, value, std in found
                    ],
                }
                for name, found in sets.items()
            },
            "theta": {
                "names": list(SYMBOLS),
                "values": nulled(self.theta),
                "covariance": nulled(self.covariance),
            },
        }


def interval_95(value: float, std: float) -> Float[np.ndarray, "2"]:
    """The 95 % interval."""
    return value + NINETY_FIVE * std * np.array([-1.0, 1.0])


def added_body(
    theta: Float[np.ndarray, "10"], covariance: Float[np.ndarray, "10 10"]
) -> AddedBody:
    """The body with these parameters.

    They are about the origin of the body's frame, its axes; NaN where not determined.
    """
    std = np.sqrt(np.diag(covariance))
    values, C = _about_com(theta, covariance)
    stds, names = np.sqrt(np.diag(C)), SYMBOLS[INERTIA]
    return AddedBody(
        theta=theta,
        covariance=covariance,
        mass=Quantity(float(theta[MASS]), float(std[MASS])),
        com=Parameters(
            ("cx", "cy", "cz"), ("mx/m", "my/m", "mz/m"), values[:3], stds[:3]
        ),
        I_com=Parameters(names, I_COM, values[3:], stds[3:]),
        I_origin=Parameters(names, names, theta[INERTIA], std[INERTIA]),
        impossible=impossible(np.sign(theta[MASS]) * values[3:], C[3:, 3:]),
    )


def _about_com(
    theta: Float[np.ndarray, "10"], covariance: Float[np.ndarray, "10 10"]
) -> tuple[Float[np.ndarray, "9"], Float[np.ndarray, "9 9"]]:
    """`c` and the inertia about it, of first order; NaN where not determined."""
    m, std = theta[MASS], np.sqrt(covariance[MASS, MASS])
    if not std < VAGUE * abs(m):
        return np.full(9, np.nan), np.full((9, 9), np.nan)
    known = np.isfinite(theta)
    at = np.where(known, theta, 0.0)
    J = np.column_stack(
        [np.imag(_com_and_inertia(at + 1j * STEP * e)) / STEP for e in np.eye(PER_BODY)]
    )
    values = _com_and_inertia(theta)
    C = J @ np.where(np.outer(known, known), covariance, 0.0) @ J.T
    told = np.isfinite(values)
    return values, np.where(np.outer(told, told), C, np.nan)


def _com_and_inertia(theta: Inexact[np.ndarray, "10"]) -> Inexact[np.ndarray, "9"]:
    """`c = s / m` and `I + [s]x [c]x`: each entry from those that it needs alone."""
    s = theta[FIRST_MOMENT]
    c = s / theta[MASS]
    I = [
        value + (s[a] * c[b] if a != b else -sum(np.delete(s * c, a)))
        for value, (a, b) in zip(theta[INERTIA], INERTIA_ENTRIES, strict=True)
    ]
    return np.array([*c, *I])


CERTAIN = 3.0
"""Standard deviations below zero that are no chance."""


def impossible(
    I_com: Float[np.ndarray, "6"], C: Float[np.ndarray, "6 6"]
) -> str | None:
    """Why no body can have this inertia about its CM; None where one can.

    Second moments are not negative in any direction `v`: `tr I / 2 - v^T I v >= 0`,
    which is least along the axis of the largest moment. Where not all of `I` is
    determined, what is determined of its diagonal must not be negative. The inertia is
    in kg m^2, NaN where not determined, and `C` is its covariance.
    """
    if np.isfinite(I_com).all():
        return _flat(I_com, C)
    for k, (a, b) in enumerate(INERTIA_ENTRIES):
        if a == b and I_com[k] < -CERTAIN * np.sqrt(C[k, k]):
            symbol = SYMBOLS[INERTIA][k]
            return f"{symbol} about its CM, {I_com[k]:.4g} kg m^2, is negative"
    return None


def _flat(I_com: Float[np.ndarray, "6"], C: Float[np.ndarray, "6 6"]) -> str | None:
    moments, axes = np.linalg.eigh(inertia_matrix(np.append(np.zeros(4), I_com)))
    v = axes[:, -1]
    g = np.array(
        [0.5 - v[a] ** 2 if a == b else -2 * v[a] * v[b] for a, b in INERTIA_ENTRIES]
    )
    if g @ I_com >= -CERTAIN * np.sqrt(g @ C @ g):
        return None
    x, y, z = (f"{moment:.4g}" for moment in moments)
    return (
        f"its principal moments {x}, {y}, {z} kg m^2 violate the triangle inequality "
        "by more than chance"
    )


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
    untrusted = rejected(before, after)
    if untrusted:
        return Comparison("rejected", untrusted)
    return _compared(before, after, body)


def _compared(before: Result, after: Result, body: str | None) -> Comparison:
    warnings = optimistic(before, after)
    difference = difference_of(before, after)
    change = total(difference)
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
        return Comparison("rejected", (*warnings, useless), change, found)
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
