"""One engine for whatever may act on a robot, or be off, beside its parameters.

What a fit takes for zero has a score (`taken_for_zero.py`); what is among its unknowns
is tested by its size in its own deviations (Wald 1943). Both are chi-square where there
is nothing, and `levels.py` says when chance explains them.

    `Search.freed`   a fit with more families among its unknowns
    `selected`       families are freed as long as chi-square says that they act

What stays undecided is in the deviations (`sensitivity.py`).
"""

from collections.abc import (
    Callable,
    Collection,
    Iterable,
    Mapping,
    Sequence,
)
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from orbident.environment.agents import SLOW, STEADY, WALKS
from orbident.estimation.levels import limit
from orbident.estimation.output_error.disturbance_sizes import sizes_of
from orbident.estimation.output_error.noise_scaling import Fitted, fitted
from orbident.estimation.output_error.problem import Problem
from orbident.estimation.output_error.solver import STEPS, solved
from orbident.estimation.output_error.taken_for_zero import TakenForZero
from orbident.estimation.solution import Linear, Prior, Solution, Unknowns

FREE = 1e3
"""SI: standard deviation beforehand of what is freed and may be anything."""

IMPOSSIBLE = 3.0
"""Deviations below zero that something positive is not by chance."""

ROUNDS = 6
"""Times that a family is freed, at most; one that was freed may be dropped again."""

TRIED = 3
"""Families, likeliest to first order, of which the one that explains most is freed; as
many instruments are tried beside them."""

BAD = 10.0
"""Chi-square of a sample beyond which it is asked whether there is any hope."""

LEFT = 0.7
"""The part of chi-square that a family leaves, at most, if it acts."""

LONGEST = 2**15
"""Rows of a recording that is tested: tables of what acts take some 3 kB a row."""

FEW_STEPS = 12
"""Steps of a search that tries something: where it is right, fewer are needed."""


@dataclass(frozen=True)
class Search:
    """Fits a recording, with any families among its unknowns."""

    problem: Problem
    prior: Prior
    """Of all unknowns of every fit."""
    starts: Sequence[Unknowns]
    """Where a search starts; from the next where that leads nowhere."""
    at_hand: list[Linear]
    """The equations at the first start, until they are used: they are large."""
    least: Mapping[str, float]
    """Levels of noise by sensor, over what is assumed at first."""
    declared: Collection[str]
    """Sensors whose noise is."""
    progress: Callable[[], object]
    steps: int
    """At most, for the weights of each round."""

    @property
    def hasty(self) -> bool:
        """Whether a search that fails is given up soon, and nothing is tested then."""
        return self.steps < STEPS

    def freed(
        self, families: Collection[str] = (), near: Unknowns | None = None
    ) -> Solution:
        """The least cost with these families free, with the noise that is assumed.

        Args:
            families: of what may act, or names of errors of instruments.
            near: where another fit of the recording ended. Its search is a trial, of
                few steps: where these families act, more are not needed.
        """
        more = self.problem.unknowns(families)
        prior = self.prior.extended(np.array([each.std or FREE for each in more]))
        places = np.array([each.place for each in (*self.problem.declared, *more)])
        here = self.at_hand.pop() if self.at_hand else None
        steps = self.steps if near is None else min(self.steps, FEW_STEPS)
        solution = None
        for start in (near, *self.starts):
            if start is None or (solution is not None and solution.converged):
                continue
            solution = solved(
                self.problem,
                self.problem.weights,
                prior,
                start.carried(places),
                self.progress,
                steps,
                None if more else here,
            )
            here = None
        assert solution is not None
        return solution

    def settled(self, first: Callable[[], Solution]) -> Fitted:
        """Go on from a first solution, with the noise that the residuals show."""
        return fitted(
            self.problem,
            first,
            self.least,
            self.declared,
            self.progress,
            self.steps,
            self.hasty,
        )


class Selection(NamedTuple):
    """A fit in which some of what may act is unknown too."""

    zeros: TakenForZero
    """What it takes for zero."""
    found: Fitted
    families: tuple[str, ...]
    base: Fitted
    """The fit with those alone that are known to act."""


def selected(
    search: Search, asked: tuple[str, ...] = (), excluded: Collection[str] = ()
) -> Selection:
    """Free one family after another, as long as chi-square says that it acts.

    Args:
        search: fits the recording.
        asked: families that are known to act: these are free in any case.
        excluded: families that are not tested.
    """
    problem = search.problem
    base = search.settled(partial(search.freed, asked))
    # In all first fits noise is that assumed, so that their costs can be compared.
    solution, families, cost = base.solution, asked, base.assumed
    tested = problem.t.size <= LONGEST
    tested &= solution.converged or not (search.hasty and _bad(problem, cost))
    every = {each.family for each in problem.acting.unknowns} if tested else set()
    # Beside a slow torque that is known to act another one would follow anything.
    slow = SLOW if {*SLOW, *WALKS} & {*asked} else ()
    pool = every - {*excluded, *slow, *asked}
    zeros = first = TakenForZero(problem, solution, pool)
    for _ in range(ROUNDS):
        more = _best(zeros, families, cost, search)
        if more is None:
            break
        solution, families = more
        # A family that stood for this one is not needed beside it.
        while weak := _unneeded(problem, solution, families, asked):
            families = _without(families, weak)
            solution = search.freed(families, solution.state)
        zeros = TakenForZero(problem, solution, zeros.families)
        cost = solution.cost
    found = base if families == asked else search.settled(lambda: solution)
    while weak := _unneeded(problem, found.solution, families, asked):
        families = _without(families, weak)
        near = found.solution.state
        found = base
        if families != asked:
            found = search.settled(partial(search.freed, families, near))
    if families != asked:
        beside = {*pool} - {*families, *(SLOW if {*SLOW} & {*families} else ())}
        first = TakenForZero(problem, found.solution, beside)
    return Selection(first, found, families, base)


def _without(families: tuple[str, ...], family: str) -> tuple[str, ...]:
    return tuple(each for each in families if each != family)


def _with(families: tuple[str, ...], family: str) -> tuple[str, ...]:
    """One more, but of those that change slowly one only, and with its mean.

    Two of them, in inertial and in base axes, follow whatever changes slowly.
    """
    others = SLOW if family in SLOW else ()
    mean = (STEADY[family],) if family in STEADY else ()
    left = (each for each in families if each not in {*others, *mean})
    return (*left, *mean, family)


def _best(
    zeros: TakenForZero, families: tuple[str, ...], cost: float, search: Search
) -> tuple[Solution, tuple[str, ...]] | None:
    """The solution with the family that explains most; None where there is no hope.

    It explains more than those before it, of which it may take the place of one.

    An instrument that is off may look like a torque that changes slowly. Where its
    error, one number, explains the recording better than all numbers of a family do,
    nothing is freed: the checks of the residuals then say what is wrong.
    """
    tried, problem, near = [], zeros.problem, zeros.solution.state
    for family in _likely(zeros, {*zeros.families} - {*families}):
        together = _with(families, family)
        more = search.freed(together, near)
        freed = problem.unknowns({*together} - {*families})
        worth = more.cost + limit("disturbance", len(freed))
        if worth < cost and not _impossible(problem, more, family):
            tried.append((worth, more, together))
    if not tried:
        return None
    least, *best = min(tried, key=lambda each: each[0])
    if _hopeless(problem, best[0], cost):
        return None
    for instrument in _likely(zeros, {each.name for each in zeros.errors}):
        with_it = search.freed((*families, instrument), near)
        if with_it.cost + limit("disturbance", 1) < least:
            return None
    return best[0], best[1]


def _hopeless(problem: Problem, more: Solution, before: float) -> bool:
    """Whether the fit is bad, and a family more explains hardly any of it.

    At no least cost the next test would mean as little as the one before.
    """
    little = more.cost > LEFT * before
    return _bad(problem, more.cost) and (little or not more.converged)


def _bad(problem: Problem, cost: float) -> bool:
    samples = sum(int((weight > 0).sum()) for weight in problem.weights.values())
    return cost > BAD * samples


def _likely(zeros: TakenForZero, names: Collection[str]) -> list[str]:
    """Those by which chi-square falls beyond what chance does, most of all."""
    beyond = {}
    for name in sorted(names):
        found = zeros.score({name, *({STEADY.get(name, name)} & {*names})})
        beyond[name] = found.fall - limit("disturbance", found.values.size, len(names))
    likely = sorted(
        (name for name in beyond if beyond[name] > 0), key=lambda name: -beyond[name]
    )
    return likely[:TRIED]


def _unneeded(
    problem: Problem,
    solution: Solution,
    families: Iterable[str],
    asked: Collection[str],
) -> str | None:
    """The family of least size in its deviations, where that is no more than chance."""

    def beyond_chance(family: str) -> float:
        value, C = sizes_of(problem, solution, family)
        return float(
            value @ np.linalg.solve(C, value) - limit("disturbance", value.size)
        )

    freed = (family for family in families if family not in asked)
    weakest = min(freed, key=beyond_chance, default=None)
    return None if weakest is None or beyond_chance(weakest) > 0 else weakest


def _impossible(problem: Problem, solution: Solution, family: str) -> bool:
    """Whether it pushes where it can only brake."""
    value, C = sizes_of(problem, solution, family)
    positive = np.array([each.positive for each in problem.unknowns([family])])
    return bool((positive & (value < -IMPOSSIBLE * np.sqrt(np.diag(C)))).any())
