"""How strong white torques and forces from outside are, where nothing is declared.

Where all other unknowns are eliminated, the equations of a walk's waves (`walks.py`)
are `R c = z + e`, with `e` of unit variance and `c` of the variance `q^2`, so that

    z ~ N(0, 1 + q^2 R R'),   -2 ln L = ln |1 + q^2 R R'| + z' (1 + q^2 R R')^-1 z

The most likely density `q` is that of restricted likelihood (Harville 1977).
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import minimize

from orbident.estimation.output_error.disturbance_sizes import members, places_of
from orbident.estimation.output_error.problem import Problem
from orbident.estimation.output_error.walks import WALKS
from orbident.estimation.solution import Solution

RANGE = 1e6
"""How far a density may be from the last guess, as a factor."""

STEP = 0.05
"""Step of a density's logarithm for second differences: it is known to some tenths."""

ROUNDS = 6
"""Times that densities are estimated, from equations at better and better states."""

SETTLED = 0.1
"""Change of a density's logarithm that changes no deviation by more than a tenth."""


class Density(NamedTuple):
    """How strong a walk most likely is; N m/sqrt(Hz), or N/sqrt(Hz)."""

    value: float
    std: float


def most_likely(
    R: Sequence[Float[np.ndarray, "n _"]],
    z: Float[np.ndarray, " n"],
    noise: Float[np.ndarray, "n n"],
    guess: Sequence[float],
) -> list[Density]:
    """The densities of walks whose equations are `sum_k R_k c_k = z + e`.

    Args:
        R: of each walk.
        z: of all together.
        noise: the covariance of `e`.
        guess: a density of each, above zero.
    """
    squares = [each @ each.T for each in R]

    def misfit(logs: Float[np.ndarray, " walks"]) -> float:
        C = noise + sum(
            np.exp(2 * log) * square for log, square in zip(logs, squares, strict=True)
        )
        factor = cho_factor(C)
        spread = 2 * float(np.sum(np.log(np.diag(factor[0]))))
        return spread + float(z @ cho_solve(factor, z))

    start, reach = np.log(np.array(guess, float)), np.log(RANGE)
    limits = [(each - reach, each + reach) for each in start]
    logs = minimize(misfit, start, method="Nelder-Mead", bounds=limits).x
    steps = STEP * np.eye(logs.size)
    bends = [misfit(logs + e) - 2 * misfit(logs) + misfit(logs - e) for e in steps]
    # Where nothing walks, the likelihood is flat: any smaller density is as likely.
    log_std = STEP * np.sqrt(2 / np.maximum(bends, STEP**2))
    return [
        Density(float(np.exp(log)), float(np.exp(log) * std))
        for log, std in zip(logs, log_std, strict=True)
    ]


def densities(
    problem: Problem, solution: Solution, unknown: Sequence[str]
) -> dict[str, Density]:
    """The most likely density of every walk of which the robot file declares none.

    Args:
        problem: a recording's equations.
        solution: of these, with the waves of all walks as its last unknowns.
        unknown: groups of waves; the density of any other walk is taken as it is.
    """
    acting = [name for name in WALKS if places_of(problem, [name]).size]
    waves = [places_of(problem, [name]).size for name in acting]
    n, state, prior = sum(waves), solution.state, solution.prior
    std = prior.std.copy()
    std[-n:] = np.inf
    factor = prior._replace(std=std).added(solution.linear.common, state)
    R, z = factor[-1 - n : -1, -1 - n : -1], factor[-1 - n : -1, -1]
    parts = dict(zip(acting, np.split(R, np.cumsum(waves)[:-1], axis=1), strict=True))
    before = {name: next(members(problem, name)).std for name in acting}
    noise = np.eye(n)
    for name in acting:
        if name not in unknown:
            noise += before[name] ** 2 * parts[name] @ parts[name].T
    found = most_likely(
        [parts[name] for name in unknown],
        z + R @ state.common[-n:],
        noise,
        [before[name] for name in unknown],
    )
    return dict(zip(unknown, found, strict=True))


def with_densities(
    problem: Problem, asked: Sequence[str], fit: Callable[[Problem], Solution]
) -> tuple[Problem, dict[str, float]]:
    """Take walks of which no density is declared to be as strong as is most likely.

    Args:
        problem: a recording's equations.
        asked: groups that act, among them perhaps walks.
        fit: finds a solution with these groups.

    Returns:
        The equations, and the deviation of each density that was estimated, by group.
    """
    walk = dict(zip(WALKS, problem.acting.followed.robot.momentum_walk, strict=True))
    unknown = [group for group in WALKS if group in asked and not walk[group]]
    found = {}
    for _ in range(ROUNDS if unknown else 0):
        before, found = found, densities(problem, fit(problem), unknown)
        values = {group: each.value for group, each in found.items()}
        problem = problem._replace(acting=problem.acting.walking(values))
        if before and all(_near(found[group], before[group]) for group in unknown):
            break
    return problem, {group: each.std for group, each in found.items()}


def _near(one: Density, other: Density) -> bool:
    return bool(abs(np.log(one.value / other.value)) < SETTLED)
