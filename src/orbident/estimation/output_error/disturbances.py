"""Tests for what acts from outside.

A disturbance that is taken for zero is tested by how far chi-square would fall to first
order if it were an unknown (score test); one that is among the unknowns by its size in
its own deviations (Wald, 1943). Both are chi-square where nothing acts.
"""

from collections.abc import Callable, Collection
from functools import partial
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float

from orbident.environment.agents import FILM, IN_WORDS, NEEDS, SLOW, STEADY, WALKS
from orbident.errors import InputError
from orbident.estimation.levels import limit
from orbident.estimation.output_error.disturbance_sizes import (
    members,
    places_of,
    sizes_of,
)
from orbident.estimation.output_error.noise_scaling import Fitted
from orbident.estimation.output_error.problem import Problem
from orbident.estimation.output_error.sensitivity import TakenForZero
from orbident.estimation.output_error.torques_or_losses import instead
from orbident.estimation.solution import Prior, Solution, Unknowns
from orbident.estimation.unknowns import explained

FREE = 1e3
"""SI: standard deviation beforehand of a disturbance that may exist."""

IMPOSSIBLE = 3.0
"""Deviations below zero that something positive is not by chance."""

ROUNDS = 6
"""Times that a group is freed, at most; one that was freed may be dropped again."""

TRIED = 3
"""Groups, likeliest to first order, of which the one that explains most is freed; as
many instruments are tried beside them."""

BAD = 10.0
"""Chi-square of a sample beyond which it is asked whether there is any hope."""

LEFT = 0.7
"""The part of chi-square that a group leaves, at most, if it acts."""

LONGEST = 2**15
"""Rows of a recording that is tested: tables of what acts take some 3 kB a row."""


class Fit(NamedTuple):
    """A fit in which some of what may act from outside is unknown too."""

    zeros: TakenForZero
    """What it takes for zero."""
    found: Fitted
    groups: tuple[str, ...]
    plain: Fitted
    """The fit in which nothing acts."""
    instead: dict[str, Float[np.ndarray, " beta"]]
    """What may act in place of a torque, by its group: how far off `beta` is then."""


@runtime_checkable
class Search(Protocol):
    """Fits a recording with more unknowns: groups, or errors of instruments."""

    def first(self, more: tuple[str, ...]) -> Solution:
        """Search with the noise that is assumed; of the unknowns the names."""
        ...

    def whole(self, first: Callable[[], Solution]) -> Fitted:
        """Go on from a first solution, with the noise that the residuals show."""
        ...


def with_disturbances(
    problem: Problem,
    search: Search,
    excluded: Collection[str] = (),
    asked: tuple[str, ...] = (),
    hasty: bool = False,
) -> Fit:
    """Free one group after another, as long as chi-square says that it acts.

    Args:
        problem: a recording's equations.
        search: finds a fit with some groups.
        excluded: groups that are not tested.
        asked: groups that are known to act: these are free in any case.
        hasty: whether nothing is tested where a bad search found no least cost.
    """
    plain = search.whole(partial(search.first, ()))
    # In all first fits noise is that assumed, so that their costs can be compared.
    solution, groups, cost = plain.solution, asked, plain.assumed
    if asked:
        solution = search.first(asked)
        cost = solution.cost
    tested = problem.t.size <= LONGEST
    tested &= solution.converged or not (hasty and _bad(problem, cost))
    every = {each.group for each in problem.acting.disturbances} if tested else set()
    # Beside a slow torque that is known to act another one would follow anything.
    slow = SLOW if {*SLOW, *WALKS} & {*asked} else ()
    zeros = first = TakenForZero(problem, solution, every - {*excluded, *slow})
    for _ in range(ROUNDS):
        more = _best(zeros, groups, cost, search)
        if more is None:
            break
        solution, groups = more
        # A group that stood for this one is not needed beside it.
        while weak := _unneeded(problem, solution, groups, asked):
            groups = _without(groups, weak)
            solution = search.first(groups)
        zeros = TakenForZero(problem, solution, zeros.groups)
        cost = solution.cost
    found = search.whole(lambda: solution) if groups else plain
    while weak := _unneeded(problem, found.solution, groups, asked):
        groups = _without(groups, weak)
        found = search.whole(partial(search.first, groups)) if groups else plain
    if groups:
        beside = {*first.groups} - {*groups, *(SLOW if {*SLOW} & {*groups} else ())}
        zeros = TakenForZero(problem, found.solution, beside)
    else:
        zeros = first
    others = instead(problem, search.first, found, groups, asked)
    return Fit(zeros, found, groups, plain, others)


def requested(problem: Problem, names: Collection[str]) -> tuple[str, ...]:
    """Groups that the robot file says act, each once.

    Raises:
        InputError: there is none of this name, nothing of it shows in this recording,
            or the recording is too long for it.
    """
    if {*WALKS} & {*names} and problem.t.size > LONGEST:
        raise InputError(
            f"momentum that walks at random needs 20 kB a row by maximum likelihood, "
            f"and the recording has {problem.t.size} rows of at most {LONGEST}; "
            "declare momentum_walk and use --method structured"
        )
    followed = problem.acting.followed
    possible = followed.tracked and problem.t.size <= LONGEST
    if not possible and FILM not in (followed.robot.disturbances or ()):
        # Pads imply it, which is no reason to refuse.
        names = [name for name in names if name != FILM]
    every = {each.group for each in problem.acting.disturbances} if names else set()
    for name in names:
        if name not in IN_WORDS:
            known = ", ".join(IN_WORDS)
            raise InputError(f"disturbance '{name}' is unknown; use {known}")
        if name not in every:
            raise InputError(
                f"disturbance '{name}' is asked for, and shows in no "
                f"recording without {NEEDS[name]}; give that, or do not ask for it"
            )
    return tuple(dict.fromkeys(names))


def _without(groups: tuple[str, ...], group: str) -> tuple[str, ...]:
    return tuple(each for each in groups if each != group)


def _with(groups: tuple[str, ...], group: str) -> tuple[str, ...]:
    """One more, but of those that change slowly one only, and with its mean.

    Two of them, in inertial and in base axes, follow whatever changes slowly.
    """
    others = SLOW if group in SLOW else ()
    mean = (STEADY[group],) if group in STEADY else ()
    left = (each for each in groups if each not in {*others, *mean})
    return (*left, *mean, group)


def _best(
    zeros: TakenForZero,
    groups: tuple[str, ...],
    cost: float,
    search: Search,
) -> tuple[Solution, tuple[str, ...]] | None:
    """The solution with the group that explains most; None where there is no hope.

    It explains more than those before it, of which it may take the place of one.

    An instrument that is off may look like a torque that changes slowly. Where its
    error, one number, explains the recording better than all numbers of a group do,
    nothing is freed: the checks of the residuals then say what is wrong.
    """
    tried, problem = [], zeros.problem
    for group in _likely(zeros, {*zeros.groups} - {*groups}):
        together = _with(groups, group)
        more = search.first(together)
        freed = places_of(problem, {*together} - {*groups})
        worth = more.cost + limit("disturbance", freed.size)
        if worth < cost and not _impossible(problem, more, group):
            tried.append((worth, more, together))
    if not tried:
        return None
    least, *best = min(tried, key=lambda each: each[0])
    if _hopeless(problem, best[0], cost):
        return None
    for instrument in _likely(zeros, {each.name for each in zeros.errors}):
        if search.first((*groups, instrument)).cost + limit("disturbance", 1) < least:
            return None
    return best[0], best[1]


def _hopeless(problem: Problem, more: Solution, before: float) -> bool:
    """Whether the fit is bad, and a group more explains hardly any of it.

    At no least cost the next test would mean as little as the one before.
    """
    little = more.cost > LEFT * before
    return _bad(problem, more.cost) and (little or not more.converged)


def _bad(problem: Problem, cost: float) -> bool:
    samples = sum(int((weight > 0).sum()) for weight in problem.weights.values())
    return cost > BAD * samples


def start_with(
    problem: Problem, prior: Prior, state: Unknowns, more: Collection[str]
) -> tuple[Prior, Unknowns]:
    """Where a search starts with these among the unknowns, all of them zero.

    Args:
        problem: a recording's equations.
        prior: of all other unknowns.
        state: of these.
        more: names of groups, or of errors of instruments.
    """
    places = places_of(problem, more)
    std = [_beforehand(problem, place) for place in places]
    return prior.extended(np.array(std)), state.selecting(places)


def _beforehand(problem: Problem, place: float) -> float:
    which = np.flatnonzero(problem.acting.places == place)
    known = problem.acting.disturbances[which[0]].std if which.size else 0.0
    return known or FREE


def _likely(zeros: TakenForZero, names: Collection[str]) -> list[str]:
    """Those by which chi-square falls beyond what chance does, most of all."""
    beyond = {}
    for name in sorted(names):
        mean = {STEADY.get(name, name)} & {*names}
        places = places_of(zeros.problem, {name, *mean})
        left = zeros.equations(places)
        fallen = explained(left[:, :-1], left[:, -1]).fall
        beyond[name] = fallen - limit("disturbance", places.size, len(names))
    likely = sorted(
        (name for name in beyond if beyond[name] > 0), key=lambda name: -beyond[name]
    )
    return likely[:TRIED]


def _unneeded(
    problem: Problem,
    solution: Solution,
    groups: Collection[str],
    asked: Collection[str],
) -> str | None:
    """The group of least size in its deviations, where that is no more than chance."""

    def beyond_chance(group: str) -> float:
        value, C = sizes_of(problem, solution, group)
        return float(
            value @ np.linalg.solve(C, value) - limit("disturbance", value.size)
        )

    freed = (group for group in groups if group not in asked)
    weakest = min(freed, key=beyond_chance, default=None)
    return None if weakest is None or beyond_chance(weakest) > 0 else weakest


def _impossible(problem: Problem, solution: Solution, group: str) -> bool:
    """Whether it pushes where it can only brake."""
    value, C = sizes_of(problem, solution, group)
    positive = np.array([each.positive for each in members(problem, group)])
    return bool((positive & (value < -IMPOSSIBLE * np.sqrt(np.diag(C)))).any())
