"""Levenberg and Marquardt's method on the eliminated equations.

The damping follows the ratio of the fall in cost to that expected (Nielsen 1999). A
step without damping that leads too far is shortened first: what samples hardly show
curves, steps lead from one side of the least cost to the other, and damping would hold
just that direction. The part of it is where the parabola is least that has the slope
and the costs at both ends (Dennis and Schnabel 1983, section 6.3.2). Where a step turns
back, the next state is between the ends of both (Anderson 1965, with one step before).
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.linalg import solve_triangular

from orbident.estimation.output_error.problem import Problem, linear
from orbident.estimation.solution import (
    SMALL,
    BySensor,
    Convergence,
    Linear,
    Prior,
    Solution,
    Step,
    Unknowns,
)
from orbident.estimation.triangular import check_finite, fold
from orbident.recordings.long_recording import LARGE

SAME = 0.01
"""Chi-square: what differs by less is as likely. Where noise lasts, or weights depend
on the state, the equations' solution is not quite where the cost is least."""

STEPS = 20
"""The most that a search takes."""
DAMPING = 1e-3
"""Where a step without damping did not help; relative to the information."""
LEAST_DAMPING = 1e-6
MOST_DAMPING = 1e9
"""With less a step is as without; with more it is too short to change anything."""
FALLS = 0.5
"""A step is corrected again while the cost falls to less than this part of it."""
RAISED = 2.0
"""Times, where a step did not help; twice as much at the next."""

SHORTEST = 0.1
"""Part of a step below which it is damped instead: it is wrong in kind."""

CORNER = 0.5
"""Deviations. The rate at a row in which a thruster switches changes with its clock to
one side only. Where the least cost is at such a corner, steps lead from one side of it
to the other, are shorter than this, and lower nothing: the search ends there too."""

AGAIN = 3
"""Steps that lower nothing, one after the other, at a corner."""

KEPT = 2**24
"""Bytes of links that a solution keeps: without them, who asks for its boundaries
linearises again."""


class LastStep(NamedTuple):
    """A step of the common unknowns."""

    step: Float[np.ndarray, " g"]
    end: Float[np.ndarray, " g"]
    """Where it leads to."""


def solved(
    problem: Problem,
    weights: BySensor,
    prior: Prior,
    state: Unknowns,
    progress: Callable[[], object] = lambda: None,
    steps: int = STEPS,
    here: Linear | None = None,
    enough: float = 0.0,
    straight: bool = False,
) -> Solution:
    """Search for the least cost from a given state.

    Args:
        problem: a recording's equations.
        weights: the weights of its samples.
        prior: what is known beforehand.
        state: where the search starts.
        progress: is called at every step.
        steps: the most steps to take.
        here: the equations at that state, where they are at hand.
        enough: a search that only leads to another one ends, too, with a step that
            lowers the cost by a smaller part; its first step is damped.
        straight: whether a step is neither shortened, nor ends between two others: what
            is right is found without.

    Raises:
        InputError: at the first state the equations overflow.
    """
    here = here or linear(problem, weights, state)
    cost = here.cost + prior.cost(state)
    check_finite(cost, _size(here))
    damping, raised = DAMPING if enough else 0.0, RAISED
    taken, tried, vain = [Step(cost, np.nan)], False, 0
    last = None if straight else LastStep(np.zeros(state.common.size), state.common)
    for _ in range(steps):
        progress()
        here = linear(problem, weights, state) if here.given_up else here
        factor = prior.added(here.common, state)
        g, last = _next(factor, state, damping, last)
        z = here.step(g)
        change, whole = factor[:-1, :-1] @ g, factor[:-1, -1]
        size = float(np.linalg.norm(change))
        # What hardly anything shows moves in steps without damping alone.
        if size < SMALL and 0 < damping <= DAMPING and not tried:
            tried, damping = True, 0.0
            continue
        # What nothing shows would take an undamped step too far, again and again.
        if size < SMALL and damping <= DAMPING:
            # The last step may take much of the defects away: what is left is known.
            left = float(factor[-1, -1] ** 2 + np.sum((whole - change) ** 2))
            taken.append(Step(left, size))
            moved = state.moved(z, problem.acting.evenly(state, g))
            return solution_at(moved, here, prior, weights, True, left, tuple(taken))
        if problem.t.size >= LARGE:
            # Two of them would take much memory; a step that fails is rare.
            there = here = here.without_rows()
        bent = not (straight or damping)
        slope = max(float(change @ whole), 0.0) if bent else 0.0
        there, new_cost, part = _reached(
            problem, weights, prior, damping, cost, state, (z, g), slope
        )
        change, size = part * change, part * size
        if new_cost < cost + SAME:
            lowered = (cost - new_cost) / cost
            as_good = problem.gains and size < CORNER and cost - new_cost < SAME
            vain = vain + 1 if as_good else 0
            expected = change @ (2 * whole - change)
            gain = float((cost - new_cost) / expected) if new_cost < cost else 0.0
            state, here, cost, raised, tried = there.at, there, new_cost, RAISED, False
            damping *= max(1 / 3, 1 - (2 * gain - 1) ** 3)
            damping = damping if damping > LEAST_DAMPING else 0.0
            if vain == AGAIN or lowered < enough:
                break
        elif damping > MOST_DAMPING:
            break
        else:
            damping, raised = max(raised * damping, DAMPING), 2 * raised
        taken.append(Step(cost, size))
    here = linear(problem, weights, state) if here.given_up else here
    # Where curvature makes every step too long or too short, the end comes slowly.
    whole = prior.added(here.common, state)[:-1, -1]
    near = vain == AGAIN or float(whole @ whole) < SAME
    return solution_at(state, here, prior, weights, near, cost, tuple(taken))


def _corrected(
    problem: Problem,
    weights: BySensor,
    prior: Prior,
    damping: float,
    cost: float,
    moved: Unknowns,
) -> tuple[Linear, float]:
    """The equations where a step ends, and where corrections of it if it costs more.

    Continuity weighs so much that what a good step leaves of second order costs more
    than it gains: the next step takes that away (Fletcher 1982). So does the product of
    a thrust and what it moves: where both are known badly, a good step is long.
    """
    last = np.inf
    there, new_cost = equations_at(problem, weights, prior, moved)
    while cost <= new_cost < FALLS * last:
        last, at = new_cost, there.at
        g = _damped(prior.added(there.common, at), damping)
        moved = at.moved(there.step(g), problem.acting.evenly(at, g))
        there, new_cost = equations_at(problem, weights, prior, moved)
    return there, new_cost


def _reached(
    problem: Problem,
    weights: BySensor,
    prior: Prior,
    damping: float,
    cost: float,
    state: Unknowns,
    step: tuple[Float[np.ndarray, "boundaries local"], Float[np.ndarray, " g"]],
    slope: float,
) -> tuple[Linear, float, float]:
    """The equations where a step ends, or a part of it; their cost, and which part.

    Args:
        problem: a recording's equations.
        weights: of its samples.
        prior: what is known beforehand.
        damping: relative to the information.
        cost: where the step starts,
        state: which is there.
        step: changes of the boundaries, and of what all have in common.
        slope: half of that of the cost along the step, downwards; of zero it is not
            shortened.
    """
    (z, g), part = step, 1.0
    while True:
        moved = state.moved(part * z, problem.acting.evenly(state, part * g))
        there, new_cost = _corrected(problem, weights, prior, damping, cost, moved)
        if part < 1 or new_cost < cost + SAME:
            return there, new_cost, part
        least = slope / (new_cost - cost + 2 * slope)
        # Where an end overflows this is no number, which is not greater.
        if not least > SHORTEST:
            return there, new_cost, part
        part = least


def _next(
    factor: Float[np.ndarray, "n n"],
    state: Unknowns,
    damping: float,
    last: LastStep | None,
) -> tuple[Float[np.ndarray, " g"], LastStep | None]:
    """A step; without damping one that turns back leads to between both ends.

    That is where, on the line between its end and that of the last one, a step would be
    shortest, to first order.

    Args:
        factor: of what is known of changes of all common unknowns.
        state: where the step starts.
        damping: relative to the information.
        last: the last step without damping; without one none leads to between.

    Returns:
        The step, and the last one without damping.
    """
    g = _damped(factor, damping)
    if damping or last is None:
        return g, last
    own = LastStep(g, state.common + g)
    a, b = factor[:-1, :-1] @ g, factor[:-1, :-1] @ last.step
    if a @ b >= 0:
        return g, own
    share = a @ (a - b) / np.sum((a - b) ** 2)
    return (1 - share) * g + share * (last.end - state.common), own


def solution_at(
    state: Unknowns,
    here: Linear,
    prior: Prior,
    weights: BySensor,
    converged: bool,
    cost: float,
    convergence: Convergence = (),
) -> Solution:
    """Where a search ended, with the equations there."""
    kept = here
    if here.links.nbytes > KEPT:
        kept = here._replace(links=here.links[:0].copy())
    end = here.at_the_end()
    return Solution(state, kept, end, prior, weights, converged, cost, convergence)


def equations_at(
    problem: Problem, weights: BySensor, prior: Prior, state: Unknowns
) -> tuple[Linear, float]:
    """The equations at a state, and its cost: infinite where a step led too far.

    An attitude that is half a turn off shows no turn at all.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        there = linear(problem, weights, state)
        cost = there.cost + prior.cost(state)
    sound = np.isfinite(_size(there)) and np.diag(there.factor)[: there.local].all()
    return there, cost if sound else np.inf


def _size(here: Linear) -> float:
    """That of the equations, infinite where their squares are, which are needed too."""
    with np.errstate(over="ignore", invalid="ignore"):
        return float(np.linalg.norm(here.factor))


def _damped(
    factor: Float[np.ndarray, "n n"], damping: float
) -> Float[np.ndarray, " g"]:
    if damping:
        size = np.sqrt(damping) * np.linalg.norm(factor[:-1, :-1], axis=0)
        factor = fold(factor, np.column_stack([np.diag(size), np.zeros(size.size)]))
    return solve_triangular(factor[:-1, :-1], factor[:-1, -1])
