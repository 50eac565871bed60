"""When the robot changed while it was recorded: a capture, a release, a loss.

Eqs. 24 and 31 are linear in all that is unknown. So no search is needed for what two
robots leave of them, one before a time and one after it: the triangular factors of all
parts before the time, and of all after it, say it. At a change that is far less than
one robot leaves, and far less than at other times. Output error then confirms that the
robots before and after it are not the same: what acts looks like a change, too.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import accumulate, pairwise
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from orbident.errors import InputError
from orbident.estimation.clock_search import Fit, evidence, misfit
from orbident.estimation.estimate import Change, Estimate
from orbident.estimation.levels import ChiSquare, Rule, chi_square, limit
from orbident.estimation.linear_fits import rows_of
from orbident.estimation.momentum_problem import ROUNDING, MomentumProblem
from orbident.estimation.output_error.estimator import OutputError
from orbident.estimation.output_error.least_cost import FEW_STEPS
from orbident.estimation.residual_checks import residual_checks
from orbident.estimation.triangular import fold
from orbident.model.core_robot import wheels_of

PARTS = 32
"""Equal parts into which a recording is divided; a change is looked for at the edges
between two of them."""

AROUND = 2
"""Edges so few parts away from a change are near it, and say nothing of other times."""

BEGINNING = 0.75
"""Part of a recording in which the first of its changes is looked for, where two or
more hide each other in the whole."""

SURER = 0.1
"""Times as little must be left in a part of a recording: there are many of them, and
where a momentum walks at random a part left 0.14 of what others did."""

MOST = 4
"""Robots that one recording may show, one after the other. Where something is wrong all
the time, parts of it look like many more."""

FINELY = 16
"""The two parts beside the best edge are divided into so many smaller ones, and the
change is looked for again at their edges."""

BESIDE = 3
"""Smaller parts before and after a change that are taken for neither robot: a gripper
takes its time to close, and a few samples of another robot keep a part from fitting."""

FEWEST = 100
"""A part with fewer samples is not fitted: it shows too little of a robot."""

LEAVES = 0.1
"""The most that two robots leave of the squares of Eqs. 24 and 31. Of 52 captures and
releases at random they left 0.015 at most, of good recordings 0.4 and more."""

SHARP = 0.5
"""The most that is left at a change of what is left at other times: a capture left 0.43
at most, and good recordings 0.76 and more."""

SHOWS = 1e-3
"""Part of the right side of an equation that must not be constant. Recordings of wheels
that keep their speed had 5e-6, of others 0.3 and more."""

ANOTHER_ROBOT: Rule = "other parameters"
"""Which test says that two parts are not of one robot."""


Equations = Sequence[Float[np.ndarray, "samples _ _"]]
"""Rows of Eq. 24, and those of Eq. 31, by sample, axis and column."""


def changes_of(problem: MomentumProblem) -> tuple[Change, ...]:
    """The changes that output error confirms, in their order.

    Args:
        problem: of the whole recording.
    """
    t, every = problem.recording.t, _by_sample(problem)
    parts = _parts(problem, every, 0, t.size) if every else []
    changes = []
    for before, after in pairwise(parts):
        off = between_robots(before.fit, after.fit)
        if off.is_no_chance(ANOTHER_ROBOT):
            over = off.value / limit(ANOTHER_ROBOT, off.dof)
            times = float(t[after.first]), float(t[before.last - 1])
            changes.append(Change(*times, over, 1 - off.p))
    return tuple(changes)


class _Part(NamedTuple):
    """Rows of one robot."""

    first: int
    last: int
    """The row after them."""
    fit: Fit


def _by_sample(problem: MomentumProblem) -> Equations:
    """The linear equations, where these know all that moves the robot."""
    samples, recorded = problem.samples, problem.recording.t.size
    if not problem.linear or samples.t.size != recorded:
        return []
    batch, wheels = samples.batch(0, recorded), wheels_of(problem.robot)
    every = rows_of(problem.sets.regressors, wheels, None, batch, samples.drift())
    by_sample = [rows.reshape(recorded, -1, rows.shape[1]) for rows in every]
    return [rows for rows in by_sample if shows_a_robot(rows)]


def shows_a_robot(rows: Float[np.ndarray, "samples axes _"]) -> bool:
    """Whether more than a constant explains the right side of an equation.

    Wheels of one speed on a table have a momentum that the constant one balances, and
    parameters of zero fit as well as any.
    """
    axes = rows.shape[1]
    constant = rows[..., [*range(axes), -1]].reshape(-1, axes + 1)
    R = fold(np.zeros((axes + 1,) * 2), constant)
    return bool(abs(R[-1, -1]) > SHOWS * np.linalg.norm(rows[..., -1]))


def _parts(
    problem: MomentumProblem, every: Equations, first: int, last: int
) -> list[_Part]:
    """The rows from `first` to `last`, divided into parts of one robot each.

    Nothing where no change is seen, or one of the parts is of no single robot.
    """
    whole = last - first == problem.recording.t.size
    between = _between(every, first, last, 1.0 if whole else SURER)
    if between is None:
        return []
    parts = list[_Part]()
    for start, end in (first, between[0]), (between[1], last):
        fit = _fitted(problem, start, end)
        found = [_Part(start, end, fit)] if fit else _parts(problem, every, start, end)
        if not found or len(parts) + len(found) > MOST:
            return []
        parts += found
    return parts


def _between(
    every: Equations, first: int, last: int, most: float
) -> tuple[int, int] | None:
    """Rows before and after a change; None where the linear equations see none.

    Two changes may hide each other: then a part shows one of them.

    Args:
        every: equations by sample.
        first: the first row of what is looked at.
        last: the row after its last one.
        most: part of `LEAVES` and of `SHARP` that may be left.
    """
    if last - first < 2 * FEWEST:
        return None
    edges = np.linspace(first, last, PARTS + 1).astype(int)
    left = left_by_two(every, edges)
    k = AROUND + int(np.argmin(left[AROUND:-AROUND]))
    elsewhere = np.abs(np.arange(edges.size) - k) > AROUND
    if left[k] > most * min(LEAVES, SHARP * left[elsewhere].min()):
        end = first + int(BEGINNING * (last - first))
        return _between(every, first, end, SURER)
    inside = np.linspace(edges[k - 1], edges[k + 1], FINELY + 1).astype(int)
    finely = left_by_two(every, np.concatenate([[first], inside, [last]]))
    # Where both looks differ, it is between them.
    looks = 1 + int(np.argmin(finely[2:-2])), FINELY // 2
    good, bad = max(min(looks) - BESIDE, 0), min(max(looks) + BESIDE, FINELY)
    return int(inside[good]), int(inside[bad])


def left_by_two(
    every: Equations, edges: Int[np.ndarray, " edges"]
) -> Float[np.ndarray, " edges"]:
    """The part that two robots, one after the other, leave of what one leaves.

    It is the product of all equations' squares, by the edge between the two.

    Args:
        every: equations by sample.
        edges: rows, of which the first and the last are the ends.
    """
    product = np.ones(edges.size)
    for rows in every:
        columns = rows.shape[2]
        parts = [rows[a:b].reshape(-1, columns) for a, b in pairwise(edges)]
        start = np.zeros((columns, columns))
        before, after = (
            np.array([R[-1, -1] for R in accumulate(each, fold, initial=start)])
            for each in (parts, parts[::-1])
        )
        squares = before**2 + after[::-1] ** 2
        left = squares[0] > ROUNDING**2 * np.sum(rows[..., -1] ** 2)
        product *= squares / squares[0] if left else 1.0
    return product


def _fitted(problem: MomentumProblem, first: int, last: int) -> Fit | None:
    """What fits a part by output error; None where nothing does soon."""
    if last - first < FEWEST:
        return None
    # What was at rest was so before the first change.
    known = replace(problem, initial_momentum="unknown") if first else problem
    rows = slice(first, last)
    try:
        part = known.amended(recording=problem.recording.some(rows))
        on, shown = evidence(part, OutputError(steps=FEW_STEPS), lambda _: None)
    except InputError:
        return None
    if shown is None or not shown.converged:
        return None
    good = all(x.level != "do not trust" for x in residual_checks(part, shown))
    return Fit(on, shown) if good else None


def between_robots(before: Fit, after: Fit) -> ChiSquare:
    """How far two parts are from being of one robot, as a chi-square.

    The least cost of a short part may lie in a curved valley: its deviations hold what
    is near, and not the robot that explains it nearly as well. So the later part is
    fitted again beside what the earlier one says, and costs more by so much.
    """
    numbers = differing(before.shown, after.shown)
    if not numbers.is_no_chance(ANOTHER_ROBOT):
        return numbers
    assert before.shown.shared is not None
    said = before.shown.shared()
    fit = OutputError(steps=FEW_STEPS, tested=False, others=said)
    both = fit.estimate(after.problem, lambda _: None)
    if not both.converged:
        return numbers
    equations = said.over(())
    off = equations[:, :-1] @ both.parameters.base.values - equations[:, -1]
    more = misfit(both) - misfit(after.shown) + float(off @ off)
    return numbers._replace(value=min(numbers.value, max(more, 0.0)))


def differing(one: Estimate, other: Estimate) -> ChiSquare:
    """How far two estimates of the base parameters are apart, as a chi-square."""
    a, b = one.parameters.base, other.parameters.base
    both = np.flatnonzero(a.determined & b.determined)
    # With their correlations: all may share a doubt about the scale.
    C = (a.covariance + b.covariance)[np.ix_(both, both)]
    return chi_square((a.values - b.values)[both], C)
