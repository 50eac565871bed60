"""One engine for whatever may act on a robot, or be off, beside its parameters.

What may act is among the unknowns of every fit, with a deviation beforehand
(`environment/worlds.py`), and so are errors with a tolerance, of which gains of thrust
may be far larger: valves stick. Two squares say whether
a family is what it was taken for. Of what is among the unknowns, with `x` its numbers,
`P` their covariance beforehand and `C` that afterwards,

    x' (P - C)^-1 x

since `x` varies by what the recording has told of it; what is taken for zero has a
score (`taken_for_zero.py`). Both are chi-square, and `levels.py` says when chance
explains them. Where it does not, the family is as large as is most likely.
"""

from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from orbident.environment.agents import AGENTS, FREE, SLOW, STEADY, UNTESTED, WALKS
from orbident.estimation.levels import ChiSquare, integrated_out, limit
from orbident.estimation.output_error.acting import LONGEST
from orbident.estimation.output_error.disturbance_sizes import (
    acts_backwards,
    of_no_robot,
    size_of,
    surprise_of,
)
from orbident.estimation.output_error.least_cost import Search
from orbident.estimation.output_error.noise_scaling import Fitted, is_bad
from orbident.estimation.output_error.problem import Problem
from orbident.estimation.output_error.taken_for_zero import TakenForZero, taken_for_zero
from orbident.estimation.solution import NO_EQUATIONS, Solution

ROUNDS = 6
"""Times that a family is freed, at most."""

TRIED = 3
"""Families, likeliest to first order, that are freed; and instruments beside them."""

FIRST_ORDER = 0.5
"""Part of what a family explains to first order that a likelier one does, too."""

SOME_OF_IT = 0.2
"""Part of chi-square that a family must explain to first order to make a bad fit good:
those that did, of the tables of mistakes, explained 0.39 and more."""

NOTHING = 1e-4
"""Part of what a search of too few steps explained that counts as nothing."""

FURTHER = 5.0
"""Times what an instrument would explain to first order: of 105 in 66 recordings none
explained more than 2.8 times that."""


class WorldFit(NamedTuple):
    """A fit in which all that acts is as large as the recording says."""

    search: Search
    found: Fitted
    expected: Fitted
    """That in which nothing is larger than it may be."""
    zeros: TakenForZero
    """What it takes for zero."""
    freed: tuple[str, ...] = ()
    """Families that are larger than they may be."""


def fit_as_expected(search: Search) -> WorldFit:
    """Let nothing be larger than it may be."""
    search, first = _sized(search)
    found = search.settled(first)
    zeros = taken_for_zero(search.problem, found.solution, False)
    return WorldFit(search, found, found, zeros)


def fit_in_world(fit: WorldFit, excluded: Collection[str] = ()) -> WorldFit:
    """Let a family be larger than it may be, where chance does not explain it.

    It may be taken for what is like it: that may then be as large.

    Args:
        fit: in which none is.
        excluded: families that are not tested.
    """
    search, found = fit.search, fit.found
    # In all first fits noise is that assumed, so that their costs can be compared.
    solution, cost, freed = found.solution, found.assumed, tuple[str, ...]()
    lost = search.hasty or not solution.converged
    hopeless = lost and is_bad(search.problem, cost)
    hopeless |= of_no_robot(*solution.mass, search.nominal.beta[0])
    if hopeless or search.problem.t.size > LONGEST:
        return fit
    # With the noise of the gyro in it, what is left of it beside all other unknowns is
    # noise, and seems to explain that of the gyro.
    acting = search.problem.acting.following(found.predicted(search.problem, "gyro"))
    search = replace(search, problem=search.problem._replace(acting=acting))
    zeros = taken_for_zero(search.problem, solution, True)
    while len(freed) < ROUNDS:
        # One that was freed is as large as is most likely.
        best = _best(search, zeros, cost, {*excluded, *freed})
        if best is None:
            break
        family, search, solution = best
        freed, cost = (*freed, family), solution.cost
        zeros = taken_for_zero(search.problem, solution, True)
    if freed:
        found = search.settled(lambda: solution)
        zeros = taken_for_zero(search.problem, found.solution, True)
    return WorldFit(search, found, fit.expected, zeros, freed)


def _sized(search: Search) -> tuple[Search, Callable[[], Solution]]:
    """With the most likely size of what changes slowly and may be anything.

    Returns:
        The search, and what solves it for the first time.
    """
    free = [name for name in SLOW if search.problem.acting.is_free(name)]
    if not free:
        return search, search.freed
    solution = search.freed()
    if not solution.converged:
        # Where there is no least cost there is no most likely size.
        return search, lambda: solution
    sizes = {name: size_of(search.problem, solution, name) for name in free}
    sized = search.allowing(sizes)
    return sized, lambda: sized.freed(trial=solution.state)


def _shown(problem: Problem) -> set[str]:
    """Families among the unknowns that may be larger than they should be."""
    acting = {each.family for each in problem.expected}
    return acting | {x.family for x in problem.declared if x.family in problem.gains}


def _best(
    search: Search, zeros: TakenForZero, cost: float, excluded: Collection[str]
) -> tuple[str, Search, Solution] | None:
    """The family that explains most, freed; None where there is no hope.

    Where an instrument that is off, one number, is likelier than all numbers of a
    family, or what explains most acts as nothing does, no more than a valve is freed:
    the checks of the residuals then say what is wrong.
    """
    problem = search.problem
    among = (*problem.expected, *problem.declared)
    free = {each.family for each in among if each.std == FREE}
    # Beside a slow torque that may be anything another one would follow anything.
    # A walk is as large as its density, which is no unknown here.
    beside = {*excluded, *free, *UNTESTED, *(SLOW if {*SLOW, *WALKS} & free else ())}
    beyond = _beyond(zeros, beside)
    if is_bad(problem, cost):
        # More than one valve may stick, so that the fit of one is bad, too.
        enough = dict.fromkeys(beyond, SOME_OF_IT * zeros.solution.cost)
        enough |= dict.fromkeys(problem.gains, 0.0)
        beyond = {x: fall for x, fall in beyond.items() if fall > enough[x]}
    tried = sorted(_freed(search, zeros, cost, beyond), key=lambda each: each.worth)
    found = _as_it_acts(search, zeros, cost, tried[0], beside) if tried else None
    if found is not None:
        return found
    # A valve is off whatever else is wrong.
    valve = next((each for each in tried if each.family in problem.gains), None)
    return valve and (valve.family, valve.search, valve.solution)


def _as_it_acts(
    search: Search,
    zeros: TakenForZero,
    cost: float,
    likeliest: "_Freed",
    beside: Collection[str],
) -> tuple[str, Search, Solution] | None:
    """A freed family, as large as is most likely; None where it does not act so."""
    problem, (least, family, freed, solution) = search.problem, likeliest
    if acts_backwards(problem, solution, family):
        return None
    if family in problem.gains:
        # It is an instrument itself; more than one valve may stick.
        return family, freed, solution
    if is_bad(problem, solution.cost) or _by_an_instrument(search, zeros, cost, least):
        return None
    size = size_of(freed.problem, solution, family)
    sizes = {name: each.size for name, each in problem.acting.allowed.items()}
    others = [each for each in AGENTS[family].alike if each not in beside]
    alike = {each: max(size, sizes.get(each, 0.0)) for each in others}
    own = size if family in SLOW else np.inf
    sized = search.allowing({**alike, family: own})
    solution = sized.freed(trial=solution.state)
    # Free it follows anything; as large as is most likely it may explain nothing.
    explains = cost - solution.cost > limit("disturbance", 1)
    possible = explains and _of_a_robot(search, solution, cost)
    if not possible or acts_backwards(problem, solution, family):
        return None
    return family, sized, solution


class _Freed(NamedTuple):
    """A family that was tried, with minus twice the logarithm of its evidence."""

    worth: float
    family: str
    search: Search
    solution: Solution


def _freed(
    search: Search, zeros: TakenForZero, cost: float, beyond: Mapping[str, float]
) -> list[_Freed]:
    """Free the likeliest families, one at a time; those that explain something.

    First order says which can be as likely as the first of these.
    """
    problem, tried = search.problem, list[_Freed]()
    at = zeros.solution.state
    for family in _likely(beyond):
        unlikely = tried and beyond[family] < FIRST_ORDER * beyond[tried[0].family]
        if unlikely and family not in problem.gains:
            continue
        freed = search.allowing({family: np.inf})
        solution = freed.freed(trial=at)
        numbers = len(problem.unknowns([family]))
        chance = solution.cost + limit("disturbance", numbers) >= cost
        if not chance and _of_a_robot(search, solution, cost):
            worth = integrated_out(cost, solution.cost, numbers)
            tried.append(_Freed(worth, family, freed, solution))
    return tried


def _of_a_robot(search: Search, solution: Solution, cost: float) -> bool:
    """Whether there is a least cost to compare, and of a robot."""
    ended = solution.converged or solution.left < NOTHING * (cost - solution.cost)
    return ended and not of_no_robot(*solution.mass, search.nominal.beta[0])


def _by_an_instrument(
    search: Search, zeros: TakenForZero, cost: float, least: float
) -> bool:
    """Whether one that is off is likelier than what has this evidence.

    So is what scales and balances said.
    """
    weighed = search.prior.measured
    if len(weighed):
        others = search.prior._replace(measured=NO_EQUATIONS)
        without = replace(search, prior=others).freed(trial=zeros.solution.state)
        if integrated_out(cost, without.cost, len(weighed)) < least:
            return True
    excess = zeros.errors_beyond_chance()
    for instrument in _likely(excess):
        most = cost * (1 - FURTHER * excess[instrument] / zeros.solution.cost)
        if integrated_out(cost, most, 1) < least:
            with_it = search.freed([instrument], zeros.solution.state)
            if integrated_out(cost, with_it.cost, 1) < least:
                return True
    return False


def _beyond(zeros: TakenForZero, excluded: Collection[str]) -> dict[str, float]:
    """By how much the square of each family exceeds what chance explains."""
    problem, solution = zeros.problem, zeros.solution
    squares = {
        family: surprise_of(problem, solution, family)
        for family in _shown(problem) - {*excluded}
    }
    for family in {*zeros.families} - {*excluded}:
        found = zeros.score(
            {family, *({STEADY.get(family, family)} & {*zeros.families})}
        )
        squares[family] = ChiSquare(found.fall, found.values.size)
    among, gains = max(len(squares), 1), problem.gains
    return {
        family: square.value
        - limit("instrument" if family in gains else "disturbance", square.dof, among)
        for family, square in squares.items()
        if square.dof
    }


def _likely(beyond: Mapping[str, float]) -> list[str]:
    likely = sorted(beyond, key=lambda name: (-beyond[name], name))
    return [name for name in likely if beyond[name] > 0][:TRIED]
