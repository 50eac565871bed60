"""Suspects: what may be wrong by some numbers, and how much that would explain.

At the best fit the whitened residuals change in proportion to a small change `c` of a
suspect: `c` is one unknown more, whose column is what the recording, changed by it,
would leave, less what it leaves as it is. With all other unknowns eliminated,
`R c = z` is left, and the sum of squares would fall by that of the part of `z` in the
span of `R` (score test).
"""

from collections.abc import Callable, Iterator, Sequence
from itertools import starmap
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.diagnosis.trial import NONE, Rival, Trial, trial
from orbident.errors import InputError
from orbident.estimation.allowance import spend
from orbident.estimation.clock_search import WORTH
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.output_error.problem import (
    Problem,
    changes_factor,
    problem_of,
)
from orbident.estimation.output_error.sensors import sensors_like, sensors_of
from orbident.estimation.solution import Solution
from orbident.estimation.unknowns import Score, score
from orbident.preprocessing.delays import delays
from orbident.preprocessing.followers import without_followers

ROUNDS = 4
"""Most rounds of a trial and a better guess, as long as it explains more."""

SETTLED = 0.3
"""Deviations: a change of the guess that is less brings nothing."""

Numbers = Float[np.ndarray, " numbers"]
Places = Float[np.ndarray, " selected"]


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
    rival: Callable[[Numbers], Rival] = lambda _: NONE
    """Another cause that looks like it where its numbers are these."""


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
        robot, recording, samples = problem.robot, problem.recording, problem.samples
        late = delays(robot, recording, problem.late)
        heard = without_followers(recording, samples.led)
        self.sensors = sensors_of(robot, heard, late, samples.speeds)
        self.equations = problem_of(robot, problem.sets, samples, self.sensors)

    def of(self, suspects: Sequence[Suspect]) -> list[Score]:
        """For each the numbers that lower the sum of squares most, to first order."""
        changed = [self._changed(suspect) for suspect in suspects]
        every = [one for some in changed for one in some]
        sizes = [
            suspect.small
            for suspect, some in zip(suspects, changed, strict=True)
            if some
        ]
        if not every:
            return [NOTHING for _ in suspects]
        left = self._left(every, np.concatenate(sizes))
        ends = np.cumsum([len(some) for some in changed])
        return [
            _score(left[:, end - len(some) : end], left[:, -1])
            for some, end in zip(changed, ends, strict=True)
        ]

    def _left(
        self, changed: list[tuple[Problem, Places]], sizes: Numbers
    ) -> Float[np.ndarray, "numbers columns"]:
        """`[R, z]` of all numbers, after the equations of all other unknowns."""
        state, prior = self.solution.state, self.solution.prior
        state = state._replace(selected=self._places(self.equations))
        factor = changes_factor(
            self.equations, self.solution.weights, state, changed, sizes
        )
        n = sizes.size
        free = state.selecting(np.zeros(n))
        factor = prior.extended(np.full(n, np.inf)).added(factor, free)
        return factor[-1 - n : -1, -1 - n :]

    def _changed(self, suspect: Suspect) -> list[tuple[Problem, Places]]:
        """The equations with each number changed; none if these cannot be compared."""
        try:
            # What overflows has no score.
            with np.errstate(all="ignore"):
                every = [
                    self._equations(suspect.corrected(self.problem, c))
                    for c in np.diag(suspect.small)
                ]
        except (InputError, np.linalg.LinAlgError):
            return []
        changed = [(each, self._places(each)) for each in every]
        return changed if all(starmap(self._comparable, changed)) else []

    def _equations(self, changed: MomentumProblem) -> Problem:
        """Those of a change so small that noise, and what acts, stay the same."""
        spend(changed.samples.t.size)
        robot, recording = changed.robot, changed.recording
        late = delays(robot, recording, changed.late)
        heard = without_followers(recording, changed.samples.led)
        sensors = sensors_like(self.sensors, robot, heard, late)
        return problem_of(
            robot, changed.sets, changed.samples, sensors, like=self.equations
        )

    def _comparable(self, equations: Problem, places: Places) -> bool:
        """Whether rows, intervals and errors are the same."""
        solution = self.solution
        same = np.array_equal(equations.boundaries, self.equations.boundaries)
        # A joint that is held moves when its encoder is put right, or the other way.
        same &= equations.recorded.local == self.equations.recorded.local
        same &= all(len(x) == equations.t.size for x in solution.weights.values())
        return bool(same and places.size == solution.state.selected.size)

    def _places(self, equations: Problem) -> Places:
        """Where the solution's errors and disturbances are where wheels are others."""
        every = (*equations.declared, *equations.acting.expected)
        return np.array([x.place for x in every if x.name in self.solution.names])


def _score(R: Float[np.ndarray, "n numbers"], z: Float[np.ndarray, " n"]) -> Score:
    return score(R, z) if np.isfinite(R).all() and R.any() else NOTHING


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
        rival = max(found.rival, suspect.rival(numbers))
        found = found.with_price(price)._replace(rival=rival)
        if not (found.accepted or found.misfit < best.misfit - WORTH):
            break
        best = found
        if found.estimate is None or found.estimate.solution is None:
            break
        # Scores are of a best fit.
        if found.lost or found.misfit > before:
            break
        (more,) = Scores(right, found.estimate.solution).of([suspect])
        if not more.fall or np.all(abs(more.values) < SETTLED * more.std):
            break
        numbers = numbers + more.values
        if found.accepted:
            # Numbers that are a little off are accepted, too: these are nearer.
            best = found._replace(cause=suspect.words(numbers))
            break
    yield best
