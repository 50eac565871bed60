"""A robot that changes while it is recorded: when it did, and what it is after that.

A filter that learns from CAD on takes its own errors for a change now and then. All
samples between two changes, fitted at once by output error, know better: a change is
one where the robots before and after it are not the same.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from orbident.errors import InputError
from orbident.estimation.clock_search import Evidence, evidence
from orbident.estimation.estimate import Change, Estimate, Progress
from orbident.estimation.levels import chi_square
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.output_error.estimator import OutputError
from orbident.estimation.output_error.hypotheses import FEW_STEPS
from orbident.estimation.residual_checks import residual_checks

FEWEST = 100
"""Samples of a part that output error is asked about: of fewer it learns little."""

EARLIER = 60
"""Samples before a change was found that may be after it: a filter that learns takes up
some of a change before it sees the rest."""


def same_robot(one: Estimate, other: Estimate) -> bool:
    """Whether chance explains by how much the base parameters of two parts differ."""
    a, b = one.parameters.base, other.parameters.base
    both = np.flatnonzero(a.determined & b.determined)
    # With their correlations: all may share a doubt about the scale.
    C = (a.covariance + b.covariance)[np.ix_(both, both)]
    apart = chi_square((a.values - b.values)[both], C)
    return not apart.is_no_chance("other parameters")


def since_the_last_change(
    problem: MomentumProblem, suspected: Sequence[Change], progress: Progress
) -> tuple[tuple[Change, ...], Evidence]:
    """The changes that output error confirms, and what it makes of all after the last.

    Args:
        problem: of the whole recording.
        suspected: by a filter, in their order.
        progress: is called with the fraction of the work that is done.
    """
    confirmed, begin = list[Change](), -np.inf
    doubt = EARLIER * float(np.median(np.diff(problem.recording.t)))
    ends = [*(change.t - doubt for change in suspected), np.inf]
    before = _between(problem, begin, ends[0])
    for done, (change, end) in enumerate(zip(suspected, ends[1:], strict=True), 1):
        progress(done / len(ends))
        # A later alarm may be none: the whole rest tells most where it fits.
        after = _between(problem, change.t, np.inf) or _between(problem, change.t, end)
        if _differ(before, after):
            confirmed.append(change)
            begin, before = change.t, after
        else:
            before = _between(problem, begin, end)
    last = _part(problem, begin, np.inf)
    return tuple(confirmed), evidence(last, OutputError(), progress)


def _between(problem: MomentumProblem, begin: float, end: float) -> Estimate | None:
    """What fits the part between two times, s; None where nothing does soon."""
    t = problem.recording.t
    if np.count_nonzero((t >= begin) & (t <= end)) < FEWEST:
        return None
    try:
        part = _part(problem, begin, end)
        shown = evidence(part, OutputError(steps=FEW_STEPS), lambda _: None).shown
    except InputError:
        return None
    if shown is None or not shown.converged:
        return None
    checks = residual_checks(part, shown)
    return shown if all(each.level != "do not trust" for each in checks) else None


def _part(problem: MomentumProblem, begin: float, end: float) -> MomentumProblem:
    """The problem of the rows between two times, s."""
    recording = problem.recording
    # What was at rest was so before the first change.
    first = begin < recording.t[0]
    known = problem if first else replace(problem, initial_momentum="unknown")
    return known.amended(recording=recording.between(begin, end))


def _differ(before: Estimate | None, after: Estimate | None) -> bool:
    """Whether both parts are fitted, by other parameters."""
    return bool(before and after and not same_robot(before, after))
