"""Levenberg and Marquardt's method on the eliminated equations.

The damping follows the ratio of the fall in cost to that expected (Nielsen 1999).
"""

from collections.abc import Callable
from contextlib import suppress

import numpy as np
from jaxtyping import Float
from scipy.linalg import LinAlgError, cho_factor, cho_solve, solve_triangular

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
on the state, the equations' solution is not quite where the cost is least. Where a
sample leaves more than noise does, chi-square and deviations are larger by as much."""

STEPS = 20
"""The most that a search takes."""
DAMPING = 1e-3
"""Where a step without damping did not help; relative to the information."""
LEAST_DAMPING = 1e-6
MOST_DAMPING = 1e9
"""With less a step is as without; with more it is too short to change anything."""
FALLS = 0.5
"""Boundaries are corrected again while the cost falls to less than this part of it. A
step of which that is so does not count as one: its search leads somewhere."""
RAISED = 2.0
"""Times, where a step did not help; twice as much at the next."""

NEAR = 10.0
"""Deviations: the last step's size from which on what is known beforehand may bend.
Far from the least cost it would draw the mass to zero, and all numerators with it."""

CORNER = 0.5
"""Deviations. The rate at a row in which a thruster switches changes with its clock to
one side only. Where the least cost is at such a corner, steps lead from one side of it
to the other, are shorter than this, and lower nothing: the search ends there too."""

AGAIN = 3
"""Steps one after the other that lower nothing, at a corner, or hardly anything."""

BAD = 4.0
"""Chi-square of a sample beyond which there may be no hope."""

SLOWLY = 1e-2
"""Part of a cost that is as bad below which steps lead nowhere, if some do one after
the other, and each lowers it by more than half of what that before it did: near the
least cost they lower it by less and less."""

KEPT = 2**24
"""Bytes of links that a solution keeps: without them, who asks for its boundaries
linearises again."""


def solved(
    problem: Problem,
    weights: BySensor,
    prior: Prior,
    state: Unknowns,
    progress: Callable[[], object] = lambda: None,
    steps: int = STEPS,
    here: Linear | None = None,
    enough: float = 0.0,
) -> Solution:
    """Search for the least cost from a given state.

    Args:
        problem: a recording's equations.
        weights: the weights of its samples.
        prior: what is known beforehand.
        state: where the search starts.
        progress: is called at every step.
        steps: the most steps to take, without those that lower the cost by much.
        here: the equations at that state, where they are at hand.
        enough: a search that only leads to another one ends, too, with a step that
            lowers the cost by a smaller part; its first step is damped.

    Raises:
        InputError: at the first state the equations overflow.
    """
    here = here or linear(problem, weights, state)
    cost = here.cost + prior.cost(state)
    check_finite(cost, _size(here))
    damping, raised = DAMPING if enough else 0.0, RAISED
    taken, tried, vain, slow, last = [Step(cost, np.nan)], False, 0, 0, np.inf
    samples = sum(int(np.count_nonzero(each)) for each in weights.values())
    while steps > 0:
        progress()
        steps -= 1
        here = linear(problem, weights, state) if here.given_up else here
        factor = prior.added(here.common, state)
        beyond = _beyond_noise(factor, samples)
        same, small = SAME * beyond, SMALL * np.sqrt(beyond)
        # Ratios to the mass change along a line, so that their numerators do not.
        close = taken[-1].size < NEAR
        even = problem.acting.steps_from(state)
        g = _damped(factor, damping, even.bends(close * prior.slope(state)))
        z = here.step(g)
        change, whole = factor[:-1, :-1] @ g, factor[:-1, -1]
        size = float(np.linalg.norm(change))
        # What hardly anything shows moves in steps without damping alone.
        if size < small and 0 < damping <= DAMPING and not tried:
            tried, damping = True, 0.0
            continue
        # What nothing shows would take an undamped step too far, again and again.
        if size < small and damping <= DAMPING:
            # The last step may take much of the defects away: what is left is known.
            left = float(factor[-1, -1] ** 2 + np.sum((whole - change) ** 2))
            taken.append(Step(left, size))
            moved = state.moved(z, even.changed(g))
            return solution_at(moved, here, prior, weights, True, left, tuple(taken))
        if problem.t.size >= LARGE:
            # Two of them would take much memory; a step that fails is rare.
            there = here = here.without_rows()
        moved = state.moved(z, even.changed(g))
        there, new_cost = _corrected(problem, weights, prior, damping, cost, moved)
        if new_cost < cost + same:
            lowered = (cost - new_cost) / cost
            steps += lowered > 1 - FALLS
            as_good = problem.gains and size < CORNER and cost - new_cost < same
            vain = vain + 1 if as_good else 0
            ends = FALLS * last < lowered < SLOWLY and beyond > BAD
            slow, last = slow + 1 if ends else 0, lowered
            expected = change @ (2 * whole - change)
            gain = float((cost - new_cost) / expected) if new_cost < cost else 0.0
            state, here, cost, raised, tried = there.at, there, new_cost, RAISED, False
            damping *= max(1 / 3, 1 - (2 * gain - 1) ** 3)
            damping = damping if damping > LEAST_DAMPING else 0.0
            if AGAIN in (vain, slow) or lowered < enough:
                break
        elif damping > MOST_DAMPING:
            break
        else:
            tried |= not damping
            damping, raised = max(raised * damping, DAMPING), 2 * raised
        taken.append(Step(cost, size))
    here = linear(problem, weights, state) if here.given_up else here
    end = solution_at(state, here, prior, weights, False, cost, tuple(taken))
    # Where curvature makes every step too long or too short, the end comes slowly.
    same = SAME * _beyond_noise(prior.added(here.common, state), samples)
    return end._replace(converged=vain == AGAIN or end.left < same)


def _beyond_noise(factor: Float[np.ndarray, "n n"], samples: int) -> float:
    """Chi-square that equations leave of a sample; 1 where that may be noise."""
    return max(float(factor[-1, -1] ** 2) / max(samples, 1), 1.0)


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
    than it gains. First the boundaries alone are corrected, and the parameters stay
    where the step led. Where that costs more, too, all are (Fletcher 1982).
    """
    first, first_cost = equations_at(problem, weights, prior, moved)
    there, new_cost = _met(problem, weights, prior, first, first_cost, cost)
    # Three of them at once would take much memory.
    if not new_cost < cost and problem.t.size < LARGE:
        there, new_cost = _met(
            problem, weights, prior, first, first_cost, cost, damping
        )
    return there, new_cost


def _met(
    problem: Problem,
    weights: BySensor,
    prior: Prior,
    there: Linear,
    cost: float,
    above: float = -np.inf,
    damping: float | None = None,
) -> tuple[Linear, float]:
    """The equations where intervals meet better, and their cost.

    Boundaries are corrected while that lowers the cost by much.

    Args:
        problem: a recording's equations.
        weights: the weights of its samples.
        prior: what is known beforehand.
        there: the equations that are to be corrected.
        cost: of these.
        above: a cost below which no more is corrected.
        damping: of corrections of all else, which stays without it.
    """
    last = np.inf
    while above <= cost < FALLS * last:
        last, at = cost, there.at
        g = np.zeros(at.common.size)
        if damping is not None:
            g = _damped(prior.added(there.common, at), damping)
        even = problem.acting.steps_from(at)
        moved = at.moved(there.step(g), even.changed(g))
        there, cost = equations_at(problem, weights, prior, moved)
    return there, cost


def continuous(
    problem: Problem, weights: BySensor, prior: Prior, state: Unknowns
) -> Linear:
    """The equations at a state of a looser problem, where intervals meet as they must.

    What they leave of continuity costs more than all samples: a first step that takes
    it away would lower the cost wherever it leads the parameters.
    """
    here = linear(problem, weights, state)
    cost = here.cost + prior.cost(state)
    there, new_cost = _met(problem, weights, prior, here, cost)
    return there if new_cost < cost else here


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
    last = None
    if here.links.nbytes > KEPT:
        last = here.at_the_end()
        here = here._replace(links=here.links[:0].copy())
    return Solution(state, here, last, prior, weights, converged, cost, convergence)


def equations_at(
    problem: Problem, weights: BySensor, prior: Prior, state: Unknowns
) -> tuple[Linear, float]:
    """The equations at a state, and its cost: infinite where a step led too far.

    An attitude that is half a turn off shows no turn, and a mass of zero nothing.
    """
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        there = linear(problem, weights, state)
        cost = there.cost + prior.cost(state)
    sound = np.isfinite(_size(there)) and np.diag(there.factor)[: there.local].all()
    return there, cost if sound and state.beta[0] else np.inf


def _size(here: Linear) -> float:
    """That of the equations, infinite where their squares are, which are needed too."""
    with np.errstate(over="ignore", invalid="ignore"):
        return float(np.linalg.norm(here.factor))


def _damped(
    factor: Float[np.ndarray, "n n"],
    damping: float,
    bends: Float[np.ndarray, "common common"] | None = None,
) -> Float[np.ndarray, " g"]:
    """The step; `bends` are half the second derivatives of what is known beforehand."""
    if damping:
        size = np.sqrt(damping) * np.linalg.norm(factor[:-1, :-1], axis=0)
        factor = fold(factor, np.column_stack([np.diag(size), np.zeros(size.size)]))
    root, whole = factor[:-1, :-1], factor[:-1, -1]
    if bends is not None and bends.any():
        half = solve_triangular(root, bends, trans=1, check_finite=False)
        both = solve_triangular(root, half.T, trans=1, check_finite=False)
        # Far from the least cost it may bend downwards: then it is taken as straight.
        with suppress(LinAlgError):
            curvature = cho_factor(np.eye(whole.size) + both, check_finite=False)
            bent = cho_solve(curvature, whole, check_finite=False)
            whole = bent if np.isfinite(bent).all() else whole
    return solve_triangular(root, whole)
