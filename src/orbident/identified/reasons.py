"""Why a comparison has no number, or a doubtful one, in words that say what to do."""

import numpy as np

from orbident.estimation.criteria import VAGUE
from orbident.estimation.result import Result
from orbident.files.names import joined
from orbident.identified.added_body import AddedBody
from orbident.identified.difference import Difference, determined_combinations
from orbident.identified.single_body import Explanation, free_columns
from orbident.robot.description import Robot, Structure
from orbident.robot.parameters import PER_BODY, SYMBOLS

POSSIBLE = 0.05
"""A body of this probability is worth a word."""
WHITE = "least-squares"
"""The method whose covariance knows no bias, and nothing that sensors integrate."""


def rejected(before: Result, after: Result) -> tuple[str, ...]:
    """Which of two results must not be trusted."""
    return tuple(
        f"the run {when} is rejected, so nothing is compared: " + result.refusal()
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


def lost(before: Result, after: Result) -> str:
    """What the results do not determine."""
    parts = []
    for when, result in (("before", before), ("after", after)):
        unknown = np.flatnonzero(~np.isfinite(result.base.values))
        names = [result.base.names[k] for k in unknown]
        if names:
            parts.append(f"the run {when} does not determine {joined(names)}")
    return " and ".join(parts)


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
    shows = free[determined_combinations(difference.T_c[:, PER_BODY * i + free]).alone]
    plane = " of planar motion" if holder.motion == "planar" else ""
    reasons = {}
    for k in np.flatnonzero(np.isnan(best.theta)):
        if k not in free:
            reason = f"the structure of '{best.body}' takes it as zero"
        elif k not in shows:
            reason = f"does not show in the momentum{plane}"
        else:
            reason = lost(before, after)
        reasons[SYMBOLS[k]] = reason
    return reasons


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
