"""What a fit takes for zero, and what it would be if it were among the unknowns.

At a solution the equations of what is taken for zero, `c`, after those of all other
unknowns `x`, are

    R_x dx + R_xc c = 0
             R_c  c = z

so that one linearisation gives the score of any family: the `c` of `R_c c = z` that
leaves least, and by how much chi-square would fall. The others would change by `B c`,
`R_x B = -R_xc`; so an error `c` shifts an estimate that takes it for zero by `-B c`.

An error of scale may seem likely only because it makes all momentum smaller, and with
it the sizes `w` of what may act, which are about zero. That less of it is left to be
explained too is not in these equations; so what `|w|^2` falls by does not count.
"""

from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float
from scipy.linalg import solve_triangular

from orbident.environment.agents import AGENTS, FREE, NOISE, UNTESTED
from orbident.estimation.levels import limit
from orbident.estimation.output_error.noise_as_motion import NoiseAsMotion
from orbident.estimation.output_error.problem import Problem, common_factor
from orbident.estimation.solution import OUTSIDE, Solution
from orbident.estimation.unknowns import Score, Sensitivity, Unknown, score


@dataclass(frozen=True)
class TakenForZero:
    """What a solution takes for zero: errors of instruments, and what may act."""

    problem: Problem
    solution: Solution
    families: Collection[str] = ()
    """Those of what may act that are considered beside all errors."""

    @cached_property
    def noise(self) -> NoiseAsMotion:
        """What noise of encoders shows of the solution."""
        return NoiseAsMotion(self.problem, self.solution)

    @cached_property
    def errors(self) -> tuple[Unknown, ...]:
        """The errors of instruments that the solution takes for zero."""
        selected = self.solution.state.selected
        return tuple(
            each for each in self.problem.instruments if each.place not in selected
        )

    @cached_property
    def unknowns(self) -> tuple[Unknown, ...]:
        """All of it, errors first."""
        selected = self.solution.state.selected
        acting = self.problem.unknowns(self.families) if self.families else ()
        return (*self.errors, *(one for one in acting if one.place not in selected))

    @cached_property
    def factor(self) -> Float[np.ndarray, "n n"]:
        """Triangular, over changes of the solution's unknowns, of these, and rhs."""
        places = np.array([each.place for each in self.unknowns])
        state = self.solution.state.selecting(places)
        shown = common_factor(self.problem, self.solution.weights, state)
        factor = shown.copy()
        self._with_noise_of_wheels(factor)
        prior = self.solution.prior.extended(np.full(places.size, np.inf))
        factor = self.noise.without(prior.added(factor, state), shown, state)
        self.problem.acting.forget()
        return factor

    def _with_noise_of_wheels(self, factor: Float[np.ndarray, "n n"]) -> None:
        """An error of a wheel's inertia is one of its noise's momentum, too.

        Else it would be how large that noise is beside all else, free of its prior.
        """
        size, acting = self.solution.state.common.size, self.problem.expected
        waves = slice(size - len(acting), size)
        values = self.solution.state.common[waves]
        for k, error in enumerate(self.errors, size):
            sensor, _, rest = error.name.partition(".")
            if sensor == "wheel" and rest.endswith(".inertia"):
                own = f"{NOISE}.{rest.removesuffix('inertia')}"
                named = np.array([each.name.startswith(own) for each in acting], bool)
                factor[:, k] += factor[:, waves] @ (named * values)

    def equations(self, names: Collection[str]) -> Float[np.ndarray, "zeros columns"]:
        """`[R_c, z]` of what has these names, or is of these families."""
        n = len(self.unknowns)
        left = self.factor[-1 - n : -1, -1 - n :]
        return left[:, [*self._which(names), -1]]

    def score(self, names: Collection[str]) -> Score:
        """What all of these would be if they were unknowns."""
        left = self.equations(names)
        return score(left[:, :-1], left[:, -1])

    @cached_property
    def alone(self) -> dict[str, Score]:
        """What each error of an instrument would be with no other, by its name."""
        names = [each.name for each in self.errors]
        left = self.equations(names)
        scores = [score(column[:, None], left[:, -1]) for column in left[:, :-1].T]
        values = np.array([each.values[0] for each in scores])
        by_what_acts = self._fall_of_what_acts(-self.shift(names), values)
        return {
            name: each._replace(fall=each.fall - float(fallen))
            for name, each, fallen in zip(names, scores, by_what_acts, strict=True)
        }

    def _fall_of_what_acts(
        self, by: Float[np.ndarray, "unknowns errors"], c: Float[np.ndarray, " errors"]
    ) -> Float[np.ndarray, " errors"]:
        """How much smaller what acts would be, in squared deviations, not below 0.

        Args:
            by: the change of all unknowns by each error, with the other sign.
            c: the errors.
        """
        solution, acts = self.solution, len(self.problem.expected)
        if not acts:
            return np.zeros(c.size)
        here = slice(solution.state.common.size - acts, None)
        std = solution.prior.std[here, None]
        before = solution.state.common[here, None] / std
        after = before - by[here] * c / std
        return np.maximum(np.sum(before**2 - after**2, axis=0), 0.0)

    def errors_beyond_chance(self) -> dict[str, float]:
        """By how much an instrument's error explains more than chance does, by name."""
        most = limit("disturbance", 1, max(len(self.errors), 1))
        return {name: found.fall - most for name, found in self.alone.items()}

    def shift(self, names: Collection[str]) -> Float[np.ndarray, "unknowns n"]:
        """`B`: how all unknowns of the solution change by these, of size one."""
        size = self.solution.state.common.size
        columns = [size + k for k in self._which(names)]
        R_x = self.factor[:size, :size]
        return -solve_triangular(R_x, self.factor[:size, columns])

    def _which(self, names: Collection[str]) -> list[int]:
        return [k for k, each in enumerate(self.unknowns) if {*each[:2]} & {*names}]

    @property
    def beta(self) -> slice:
        """Where `beta` is among the solution's unknowns."""
        return slice(OUTSIDE, OUTSIDE + self.solution.state.beta.size)


def taken_for_zero(problem: Problem, solution: Solution, tested: bool) -> TakenForZero:
    """What a solution takes for zero.

    Args:
        problem: a recording's equations.
        solution: of these.
        tested: whether it is asked what may act, too; but what is like something that
            is free shows as that.
    """
    shown = {each.family for each in problem.expected}
    free = {each.family for each in problem.expected if each.std == FREE}
    # To work out what may act takes some 3 kB a row.
    every = problem.acting.unknowns if tested else ()
    families = dict.fromkeys(each.family for each in every)
    apart = {*shown, *UNTESTED}
    absent = [x for x in families if x not in apart and not free & {*AGENTS[x].alike}]
    return TakenForZero(problem, solution, tuple(absent))


SMALL_ERROR = {
    "rad": ("mrad", 1e-3),
    "m": ("mm", 1e-3),
    "1": ("%", 1e-2),
    "s": ("ms", 1e-3),
}
"""What a table counts errors in, by their SI unit; any other in that unit."""


def sensitivity(zeros: TakenForZero) -> Sensitivity:
    """The effect of each calibration error that is not among a solution's unknowns.

    Args:
        zeros: of the solution.
    """
    names = [each.name for each in zeros.errors]
    size = zeros.solution.state.common.size
    root = solve_triangular(zeros.factor[:size, :size], np.eye(size))[zeros.beta]
    small = [SMALL_ERROR.get(each.unit, (each.unit, 1.0)) for each in zeros.errors]
    return Sensitivity(
        names=tuple(names),
        units=tuple(unit for unit, _ in small),
        shift=-zeros.shift(names)[zeros.beta] * np.array([one for _, one in small]),
        covariance=root @ root.T,
        alone=zeros.alone,
        left=zeros.equations(names),
    )
