"""What calibration errors that are taken for zero would do to an estimate.

At a solution the equations of the undeclared errors `c`, after those of all other
unknowns `x`, are

    R_x dx + R_xc c = 0
             R_c  c = z

An error `c` therefore shifts an estimate that takes it for zero by `R_x^-1 R_xc c`. If
one error alone were an unknown, it would be `r z / |r|^2` with `r` its column of `R_c`,
and chi-square would fall by `(r z)^2 / |r|^2` (score test).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int
from scipy.linalg import solve_triangular

from orbident.estimation.output_error.problem import OUTSIDE, Problem, linear
from orbident.estimation.output_error.solver import Solution

SMALL_ERROR = {
    "rad": ("mrad", 1e-3),
    "m": ("mm", 1e-3),
    "1": ("%", 1e-2),
    "s": ("ms", 1e-3),
}
"""By SI unit: what a table counts errors in."""


class CalibrationFit(NamedTuple):
    """A calibration error; SI or relative."""

    value: float
    std: float
    tolerance: float
    """The standard deviation beforehand, as the robot file declares it."""


class Freed(NamedTuple):
    """A calibration error as it would be if it alone were an unknown."""

    name: str
    value: float
    """SI or relative."""
    std: float
    chi2_drop: float
    """By so much chi-square would fall; of one degree of freedom without an error."""


class Sensitivity(NamedTuple):
    """What undeclared calibration errors would do to the base parameters."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    """Of the errors: mrad, mm, % or ms."""
    shift: Float[np.ndarray, "beta errors"]
    """Of the estimated `[M, sigma, iota]` by an error of one unit, SI."""
    covariance: Float[np.ndarray, "beta beta"]
    """Of the estimate."""
    freed: tuple[Freed, ...]
    left: Float[np.ndarray, "errors errors+1"]
    """`[R_c, z]`: the equations of the errors after those of all other unknowns."""

    def falls(self, which: Sequence[int]) -> float:
        """By so much chi-square would fall if all of these were unknowns."""
        return fall(self.left, np.array(which))

    def in_deviations(
        self, derivative: Float[np.ndarray, "parameters beta"]
    ) -> Float[np.ndarray, "parameters errors"]:
        """The shifts of parameters with this derivative, over their own deviations."""
        C = derivative @ self.covariance @ derivative.T
        return derivative @ self.shift / np.sqrt(np.diag(C))[:, None]


def fall(left: Float[np.ndarray, "n n+1"], which: Int[np.ndarray, " some"]) -> float:
    """How far chi-square would fall if these columns of `[R_c, z]` were unknowns."""
    R, z = left[:, list(which)], left[:, -1]
    after = z - R @ np.linalg.lstsq(R, z)[0]
    return float(z @ z - after @ after)


def after_all_others(
    problem: Problem, solution: Solution, places: Float[np.ndarray, " errors"]
) -> Float[np.ndarray, "errors errors+1"]:
    """The equations `[R_c, z]` of what a solution takes for zero, at these places."""
    factor = _with_errors(problem, solution, places)
    return factor[-1 - places.size : -1, -1 - places.size :]


def _with_errors(
    problem: Problem, solution: Solution, places: Float[np.ndarray, " errors"]
) -> Float[np.ndarray, "n n"]:
    """The factor over changes of all unknowns of a solution, then of these."""
    state, n = solution.state.selecting(places), places.size
    here = linear(problem, solution.weights, state)
    return solution.prior.extended(n, np.inf).added(here.common, state)


def sensitivity(problem: Problem, solution: Solution) -> Sensitivity:
    """The effect of each calibration error that is not among a solution's unknowns.

    Args:
        problem: a recording's equations.
        solution: where its cost is least.
    """
    errors = tuple(
        each
        for each in problem.calibrations
        if each.place not in solution.state.selected
    )
    places = np.array([float(each.place) for each in errors])
    n, state = len(errors), solution.state
    size = state.common.size + n
    factor = _with_errors(problem, solution, places)
    x = slice(size - n)
    of_beta = slice(OUTSIDE, OUTSIDE + state.beta.size)
    R_c, z = factor[size - n : size, size - n : size], factor[size - n : size, size]
    by = solve_triangular(factor[x, x], factor[x, size - n : size])
    small = [SMALL_ERROR[each.unit] for each in errors]
    root = solve_triangular(factor[x, x], np.eye(size - n))[of_beta]
    return Sensitivity(
        names=tuple(each.name for each in errors),
        units=tuple(unit for unit, _ in small),
        shift=by[of_beta] * np.array([one for _, one in small]),
        covariance=root @ root.T,
        freed=tuple(
            _freed(each.name, column, z)
            for each, column in zip(errors, R_c.T, strict=True)
        ),
        left=np.column_stack([R_c, z]),
    )


def _freed(
    name: str, column: Float[np.ndarray, " n"], z: Float[np.ndarray, " n"]
) -> Freed:
    """An error that nothing shows has an infinite deviation."""
    size = float(np.linalg.norm(column))
    if not size:
        return Freed(name, 0.0, np.inf, 0.0)
    along = float(column @ z) / size
    return Freed(name, along / size, 1 / size, along**2)
