"""Whether the mass is as well known as its deviation says.

Where little shows the scale the cost is no parabola, and deviations, which are of
first order, do not hold. By these it rises by one where the mass is held one deviation
off and all else follows: its profile (Bates and Watts 1988, section 6.1.2).
"""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from orbident.estimation.levels import TIMES_CAD
from orbident.estimation.output_error.joint_laws import HELD
from orbident.estimation.output_error.noise_scaling import Fitted
from orbident.estimation.output_error.problem import Problem
from orbident.estimation.output_error.solver import SAME, solved
from orbident.estimation.solution import OUTSIDE, Solution, Unknowns

PLAIN = 0.05
"""Relative deviation of the mass below which the cost is a parabola: in recordings of
10 to 30 s it then rose by 0.93 to 1.03."""

NO_ROBOT = 10.0
"""Deviations by which a mass is beyond what it may be: what acts drew it below zero by
three, of a robot on a table with a hose."""

ROUNDS = 6
"""Times that a search goes on at another mass, at most."""


class Profile(NamedTuple):
    """What was found on both sides of a mass."""

    rise: float
    """The cost rises by so much where the mass is held one deviation above or below its
    estimate, whichever is less; it may fall."""
    there: Unknowns
    """The state on that side."""


def of_no_robot(M: float, std: float, nominal: float) -> bool:
    """Whether the mass is far from any that CAD may have, kg.

    What acts makes no mass so: a sign does, and a torque that stands for the wheels'.
    """
    sure = NO_ROBOT * std
    return bool(M + sure < nominal / TIMES_CAD or M - sure > nominal * TIMES_CAD)


def at_its_least(
    problem: Problem,
    found: Fitted,
    settle: Callable[[Callable[[], Solution]], Fitted],
    progress: Callable[[], object],
    steps: int,
) -> Fitted:
    """Go on from another mass while the cost is less there.

    Args:
        problem: a recording's equations.
        found: what a search found.
        settle: goes on from a solution.
        progress: is called at every step.
        steps: the most that a search takes.
    """
    for _ in range(ROUNDS):
        solution = found.solution
        beside = profile(problem, solution, progress, steps)
        if beside is None:
            break
        found = found._replace(rise=beside.rise)
        if beside.rise > -SAME:
            break
        there = partial(solved, problem, problem.weights, solution.prior, beside.there)
        again = settle(partial(there, progress=progress, steps=steps))
        if not again.solution.converged:
            break
        found = again
    return found


def profile(
    problem: Problem, found: Solution, progress: Callable[[], object], steps: int
) -> Profile | None:
    """Look at both sides; None where the mass is known well, or may be zero.

    Args:
        problem: a recording's equations.
        found: their solution.
        progress: is called at every step.
        steps: at most, on either side.
    """
    state, prior, n = found.state, found.prior, found.state.common.size
    mass, std = found.mass
    if not found.converged or found.linear.given_up:
        return None
    if not PLAIN * mass < std < mass:
        return None
    along = found.covariance[-n:, -n:][:, OUTSIDE] / std**2
    sides = []
    for side in (-std, std):
        values, known = prior.values.copy(), prior.std.copy()
        values[OUTSIDE], known[OUTSIDE] = mass + side, HELD * std
        g = side * along
        even = problem.acting.steps_from(state)
        moved = state.moved(found.linear.step(g), even.changed(g))
        held = prior._replace(values=values, std=known)
        sides.append(solved(problem, found.weights, held, moved, progress, steps))
    least = min(sides, key=lambda each: each.cost)
    return Profile(least.cost - found.cost, least.state)
