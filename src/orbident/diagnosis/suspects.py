"""Suspects: what may be wrong by some numbers, and how much that would explain.

At the best fit every other unknown follows a small change `c` of the suspect to first
order, so the whitened residuals that are left, `r(c) = r + D c`, are known after one
more linearisation for each number. The sum of their squares would fall by that of the
part of `r` in the span of `D` (score test).
"""

from collections.abc import Callable, Iterator
from functools import cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.diagnosis.trial import Trial, trial
from orbident.errors import InputError
from orbident.estimation.clock_search import WORTH
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.output_error.acting import Acting, Followed
from orbident.estimation.output_error.problem import (
    Problem,
    linear,
    problem_of,
    residuals_alone,
)
from orbident.estimation.output_error.sensors import sensors_of
from orbident.estimation.solution import Solution
from orbident.estimation.unknowns import Score, score
from orbident.preprocessing.delays import delays

ROUNDS = 4
"""Most rounds of a trial and a better guess, as long as it explains more."""

SETTLED = 0.3
"""Deviations: a change of the guess that is less brings nothing."""

Numbers = Float[np.ndarray, " numbers"]


class Suspect(NamedTuple):
    """What may be wrong by some numbers, SI."""

    words: Callable[[Numbers], str]
    """What is wrong, with the numbers: a clause."""
    small: Numbers
    """A change of each number whose effect is in proportion to it."""
    corrected: Callable[[MomentumProblem, Numbers], MomentumProblem]
    """Robot and recording with these numbers put right; not yet fitted again."""
    most: float = np.inf
    """The largest that a number can be: what would have to be more is no cause."""


NOTHING = Score(np.zeros(0), np.zeros(0), 0.0)


class Scores:
    """Scores of suspects at a best fit, where each is at zero."""

    def __init__(self, problem: MomentumProblem, solution: Solution) -> None:
        """Keep what they are worked out at.

        Args:
            problem: as it is fitted.
            solution: its best fit.
        """
        self.problem, self.solution = problem, solution
        # What acts from outside follows the motion as it was recorded.
        self.followed = _equations(problem).acting.followed

    def of(self, suspect: Suspect) -> Score:
        """The numbers that lower the sum of squares most, to first order."""
        # What overflows has no score.
        with np.errstate(all="ignore"):
            try:
                moved = [
                    self._left(suspect.corrected(self.problem, c))
                    for c in np.diag(suspect.small)
                ]
            except (InputError, np.linalg.LinAlgError):
                return NOTHING
            D = np.column_stack([x - self.left for x in moved]) / suspect.small
            sized = np.linalg.norm(D, axis=0)
        if not np.isfinite(sized).all() or not sized.any():
            return NOTHING
        return score(D, -self.left)

    @cached_property
    def left(self) -> Float[np.ndarray, " n"]:
        """The residuals as they are."""
        return self._left(self.problem)

    def _left(self, changed: MomentumProblem) -> Float[np.ndarray, " n"]:
        """The whitened residuals of all sensors where all else follows."""
        solution = self.solution
        equations = _equations(changed, self.followed)
        # The places of calibrations are others where there are other wheels.
        every = (*equations.declared, *equations.acting.expected)
        places = np.array([x.place for x in every if x.name in solution.names])
        same = equations.boundaries.size == len(solution.state.x_WB)
        same &= all(len(x) == equations.t.size for x in solution.weights.values())
        if not same or places.size != solution.state.selected.size:
            raise InputError("other rows, intervals or errors: not comparable")
        state = solution.state._replace(selected=places)
        here = linear(equations, solution.weights, state)
        # After one step of all other unknowns.
        factor = solution.prior.added(here.common, state)
        g = np.linalg.solve(factor[:-1, :-1], factor[:-1, -1])
        there = residuals_alone(
            equations, solution.weights, state.moved(here.step(g), g)
        )
        return np.concatenate([table.ravel() for table in there.values()])


def _equations(problem: MomentumProblem, followed: Followed | None = None) -> Problem:
    """The equations of a problem, with what acts along another motion if one is given.

    Small changes of a sensor hardly change what acts, and working that out takes long.
    """
    robot = problem.robot
    late = delays(robot, problem.recording, problem.late)
    sensors = sensors_of(robot, problem.recording, late, problem.samples.speeds)
    equations = problem_of(robot, problem.sets, problem.samples, sensors)
    if followed is None:
        return equations
    acting = equations.acting
    along = Acting(followed, acting.first, acting.allowed)
    return equations._replace(acting=along)


def tried(
    problem: MomentumProblem, suspect: Suspect, first: Score, before: float
) -> Iterator[Trial]:
    """Identify again with the suspect put right, from a first guess of the numbers.

    Args:
        problem: as it is fitted.
        suspect: what is put right.
        first: the guess.
        before: the misfit now: what makes it worse is not tried again.
    """
    numbers, best = first.values, Trial("", False, np.inf)
    for _ in range(ROUNDS):
        try:
            right = suspect.corrected(problem, numbers).amended()
        except InputError:
            break
        found = trial(suspect.words(numbers), right)
        price = numbers.size * np.log(problem.samples.t.size)
        found = found._replace(misfit=found.misfit + price)
        if not (found.accepted or found.misfit < best.misfit - WORTH):
            break
        best = found
        if found.accepted or found.misfit > before:
            break
        if found.estimate is None or found.estimate.solution is None:
            break
        # Scores are of a best fit.
        if found.lost:
            break
        more = Scores(right, found.estimate.solution).of(suspect)
        if not more.fall or np.all(abs(more.values) < SETTLED * more.std):
            break
        numbers = numbers + more.values
    yield best
