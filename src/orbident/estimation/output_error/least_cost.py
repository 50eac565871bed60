"""The search for the least cost of a recording, with any families among its unknowns.

It starts from what linear fits or CAD say. Where that leads nowhere, the attitude may
turn nearly as it likes at first, and less and less so.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from orbident.environment.agents import FREE
from orbident.estimation.output_error.joint_laws import ENOUGH
from orbident.estimation.output_error.noise_scaling import Fitted, fitted, is_bad
from orbident.estimation.output_error.problem import Problem
from orbident.estimation.output_error.solver import STEPS, continuous, solved
from orbident.estimation.solution import Linear, Prior, Solution, Unknowns

FEW_STEPS = 12
"""Steps of a search that tries something: where it is right, fewer are needed."""


@dataclass(frozen=True)
class Search:
    """Fits a recording, with any families among its unknowns."""

    problem: Problem
    prior: Prior
    """What is known beforehand of the unknowns, where nothing acts on the robot."""
    start: Unknowns
    """Where a search starts."""
    nominal: Unknowns
    """The nominal robot, from which it starts where that leads nowhere."""
    at_hand: list[Linear]
    """The equations there, until they are used: they are large."""
    loose: Sequence[Callable[[], Problem]]
    """Make the equations of an attitude that may turn nearly as it likes, and less and
    less so; none for what is only tried: most of that is wrong, and then no least cost
    is near."""
    shows: Mapping[str, float]
    """How much of what acts they show; see `Problem`."""
    least: Mapping[str, float]
    """Levels of noise by sensor, over what is assumed at first."""
    declared: Collection[str]
    """Sensors whose noise is."""
    progress: Callable[[], object]
    steps: int
    """The most steps that a search takes with one set of the sensors' weights."""

    @property
    def hasty(self) -> bool:
        """Whether searches take few steps; of a bad fit nothing is tested then."""
        return self.steps < STEPS

    def freed(
        self, names: Collection[str] = (), trial: Unknowns | None = None
    ) -> Solution:
        """The least cost with these among the unknowns too, with the assumed noise.

        Args:
            names: of errors of instruments.
            trial: where a search starts that is a trial, of few steps.
        """
        problem, progress = self.problem, self.progress
        more = (*problem.unknowns(names), *problem.expected)
        prior = self.prior.extended(np.array([each.std or FREE for each in more]))
        places = np.array([each.place for each in (*problem.declared, *more)])
        solve = partial(solved, problem, problem.weights, progress=progress)
        here = self.at_hand.pop().carried(places) if self.at_hand else None
        few = min(self.steps, FEW_STEPS)
        state = (trial or self.start).carried(places)
        first = solve(prior=prior, state=state, steps=few, here=here)
        # Where little shows the scale, there is a least cost of no robot, too.
        found = first.converged and first.state.beta[0] > 0
        if found or trial or not self.loose:
            return first
        loosely = self._loosely(prior, self.nominal.carried(places))
        here = continuous(problem, problem.weights, prior, loosely)
        second = solve(prior=prior, state=here.at, steps=self.steps, here=here)
        return min(first, second, key=lambda each: each.cost)

    def _loosely(self, prior: Prior, at: Unknowns) -> Unknowns:
        """Where a search ends in which the attitude may turn nearly as it likes.

        An attitude that has to turn as its equations say weighs more than all samples:
        far from the least cost a step follows it alone, and leads anywhere.
        """
        for made in self.loose:
            loose = made()
            problem = self.problem._replace(recorded=loose.recorded, loose=loose.loose)
            weights, steps = problem.weights, self.steps
            found = solved(
                problem, weights, prior, at, self.progress, steps, enough=ENOUGH
            )
            at = found.state
            if is_bad(problem, found.cost):
                # What fits nothing even so is no robot's.
                break
        return at

    def allowing(self, sizes: Mapping[str, float]) -> "Search":
        """The search in a world where what may act has other sizes, by family, SI.

        A gain may be as far off.
        """
        problem, prior = self.problem, self.prior
        stds = [min(sizes.get(x.family, x.std), FREE) for x in problem.instruments]
        instruments = tuple(
            each._replace(std=std)
            for each, std in zip(problem.instruments, stds, strict=True)
        )
        std = prior.std.copy()
        std[std.size - len(problem.declared) :] = [x for x in stds if x]
        acting = problem.acting.allowing(
            {name: size for name, size in sizes.items() if name not in problem.gains}
        )
        return replace(
            self,
            problem=problem._replace(acting=acting, instruments=instruments),
            prior=prior._replace(std=std),
        )

    def settled(self, first: Callable[[], Solution]) -> Fitted:
        """Go on from a first solution, with the noise that the residuals show."""
        problem = self.problem
        found = fitted(
            problem,
            first,
            least=self.least,
            declared=self.declared,
            progress=self.progress,
            steps=self.steps,
            hasty=self.hasty,
        )
        every = (*problem.declared, *problem.expected)
        names = tuple(each.name for each in every)
        return found._replace(solution=found.solution._replace(names=names))
