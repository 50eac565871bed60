"""How large what acts from outside was identified to be.

Its numbers are among the common unknowns that a solution selects.

How strong white torques and forces from outside are, where nothing is declared.

Where all other unknowns are eliminated, the equations of a walk's waves
(`torques_and_forces.py`) are `R c = z + e`, with `e` of unit variance and `c` of the
variance `q^2`, so that

    z ~ N(0, 1 + q^2 R R'),   -2 ln L = ln |1 + q^2 R R'| + z' (1 + q^2 R R')^-1 z

The most likely density `q` is that of restricted likelihood (Harville 1977).
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Literal

import numpy as np
from jaxtyping import Float, Int
from scipy.linalg import cho_factor, cho_solve, solve_triangular
from scipy.optimize import minimize

from orbident.environment.agents import AGENTS, FREE, NOISE, STEADY, WALKS
from orbident.estimation.levels import TIMES_CAD, ChiSquare, chi_square, limit
from orbident.estimation.output_error.problem import Problem
from orbident.estimation.output_error.sensors import inertia_of_walks
from orbident.estimation.output_error.walking_rates import (
    RANGE,
    STEP,
    Density,
    densities_of_rates,
    near,
    walking_so,
)
from orbident.estimation.solution import NO_EQUATIONS, OUTSIDE, Solution, Unknowns
from orbident.estimation.unknowns import TOLD, DisturbanceFit, Unknown

ROUNDS = 6
"""Times that densities are estimated, from equations at better and better states."""

IMPOSSIBLE = 3.0
"""Deviations below zero that something positive is not by chance."""


def identified(
    problem: Problem,
    solution: Solution,
    densities: Mapping[str, Density],
    freed: Collection[str],
) -> dict[str, DisturbanceFit]:
    """What acts, by the name of each number; a walk by its density.

    It is what is seen, beyond chance, what is larger than it may be, and what may be
    anything. A torque that changes slowly and its mean may be seen together only.

    Args:
        problem: a recording's equations.
        solution: of these.
        densities: those that were estimated, by their groups.
        freed: groups that are larger than they may be.
    """
    fits = {}
    acting = [each for each in problem.acting.expected if each.family != NOISE]
    groups = {each.family: each.std for each in acting}

    def seen(*families: str) -> bool:
        value, C = sizes_of(problem, solution, *families)
        square = float(value @ np.linalg.solve(C, value))
        return square > limit("disturbance", value.size, len(groups))

    shown = {*freed, *(x for x, std in groups.items() if std == FREE or seen(x))}
    for pair in STEADY.items():
        if {*pair} <= groups.keys() - shown and seen(*pair):
            shown |= {*pair}
    for group in groups:
        if group not in shown | {*WALKS}:
            continue
        value, C = sizes_of(problem, solution, group)
        std, shift = np.sqrt(np.diag(C)), _shift(problem, solution, group)
        if group in WALKS:
            wave = problem.unknowns([group])[0]
            known = densities.get(group, Density(wave.std, 0.0))
            fits[group] = DisturbanceFit(group, wave.unit, wave.std, known.std, shift)
            continue
        for k, each in enumerate(selected_of(problem, solution.state, group)):
            fits[each.name] = DisturbanceFit(
                group, each.unit, float(value[k]), float(std[k]), shift
            )
    return fits | _of_rates(problem, densities)


def _of_rates(
    problem: Problem, densities: Mapping[str, Density]
) -> dict[str, DisturbanceFit]:
    """Walks of rates, as those of the momenta; without them fits would be others."""
    per_rate, fits = inertia_of_walks(problem.acting.followed.robot), {}
    for group in problem.walking:
        value, std = (x * per_rate[group] for x in densities[group])
        fits[group] = DisturbanceFit(group, AGENTS[group].unit, value, std, np.nan)
    return fits


def widened_by(expected: Sequence[Unknown], solution: Solution) -> float:
    """Deviations of `beta` over those if nothing acted: the geometric mean."""
    outside = [k for k, each in enumerate(expected) if each.family != NOISE]
    if not outside:
        return 1.0
    C, state = solution.covariance, solution.state
    first = len(C) - state.common.size + OUTSIDE
    beta = slice(first, first + state.beta.size)
    acts = len(C) - len(expected) + np.array(outside)
    by = np.linalg.solve(C[np.ix_(acts, acts)], C[acts, beta])
    held = np.einsum("ab,ab->b", C[acts, beta], by)
    all_of_it = np.diag(C)[beta]
    return float(np.exp(-0.5 * np.mean(np.log1p(-held / all_of_it))))


def _shift(problem: Problem, solution: Solution, group: str) -> float:
    """If `g` is zero, `beta` changes by `-C_bg C_gg^-1 g`."""
    value, C_gg = sizes_of(problem, solution, group)
    C, state = solution.covariance, solution.state
    first = len(C) - state.common.size + OUTSIDE
    beta = np.arange(first, first + state.beta.size)
    here = len(C) - state.selected.size + _places(problem, state, group)
    change = C[np.ix_(beta, here)] @ np.linalg.solve(C_gg, value)
    return float(np.max(np.abs(change) / np.sqrt(np.diag(C)[beta])))


def sizes_of(
    problem: Problem, solution: Solution, *families: str
) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, "n n"]]:
    """The numbers of families that were freed, SI, and their covariance."""
    state = solution.state
    which = _places(problem, state, *families)
    here = len(solution.covariance) - state.selected.size + which
    return state.calibration[which], solution.covariance[np.ix_(here, here)]


def surprise_of(problem: Problem, solution: Solution, family: str) -> ChiSquare:
    """How much larger a family is than it may be: `x' (P - C)^-1 x`.

    `P` is the covariance of its numbers `x` beforehand, and `C` that of the estimate.
    What the recording tells nothing of is left out.
    """
    value, C = sizes_of(problem, solution, family)
    chosen = selected_of(problem, solution.state, family)
    return _surprise(value, np.array([each.std for each in chosen]), C)


def surprise_of_rest(problem: Problem, solution: Solution) -> ChiSquare:
    """How much more momentum there was than a robot at rest may have.

    It is the square of `surprise_of`, of the angular momentum at the first sample.
    """
    axes = np.array(problem.acting.followed.sets.regressors.momentum_axes)
    state, prior, C = solution.state, solution.prior, solution.covariance
    here = len(C) - state.common.size + axes
    value = state.common[axes] - prior.values[axes]
    return _surprise(value, prior.std[axes], C[np.ix_(here, here)])


def surprise_of_known(
    solution: Solution, what: Literal["measured", "carried"]
) -> ChiSquare:
    """How far what was known beforehand is from what a recording says without it.

    It is known by equations `A x = b + e`, with `e` of unit variance, and `x` without
    them has the covariance `C`:

        (b - A x)' (1 + A C A')^-1 (b - A x)

    Args:
        solution: with these equations.
        what: which part of the prior they are.
    """
    equations, state = getattr(solution.prior, what), solution.state
    if not len(equations):
        return ChiSquare(0.0, 0)
    others = solution.prior._replace(**{what: NO_EQUATIONS})
    factor = others.added(solution.linear.common, state)
    R, z = factor[:-1, :-1], factor[:-1, -1]
    A = np.zeros((len(equations), state.common.size))
    A[:, : equations.shape[1] - 1] = equations[:, :-1]
    x = state.common + solve_triangular(R, z)
    spread = solve_triangular(R, A.T, trans=1)
    return chi_square(equations[:, -1] - A @ x, np.eye(len(A)) + spread.T @ spread)


def _surprise(
    value: Float[np.ndarray, " n"],
    std: Float[np.ndarray, " n"],
    C: Float[np.ndarray, "n n"],
) -> ChiSquare:
    told, axes = np.linalg.eigh(np.eye(std.size) - C / np.outer(std, std))
    seen = told > TOLD
    u = (axes.T @ (value / std))[seen]
    return ChiSquare(float(np.sum(u**2 / told[seen])), int(seen.sum()))


def acts_backwards(problem: Problem, solution: Solution, family: str) -> bool:
    """Whether it pushes where it can only brake."""
    value, C = sizes_of(problem, solution, family)
    chosen = selected_of(problem, solution.state, family)
    positive = np.array([each.positive for each in chosen], dtype=bool)
    return bool((positive & (value < -IMPOSSIBLE * np.sqrt(np.diag(C)))).any())


NO_ROBOT = 10.0
"""Deviations by which a mass is beyond what it may be: what acts drew it below zero by
three, of a robot on a table with a hose."""


def of_no_robot(M: float, std: float, nominal: float) -> bool:
    """Whether the mass is far from any that CAD may have, kg.

    What acts makes no mass so: a sign does, and a torque that stands for the wheels'.
    """
    sure = NO_ROBOT * std
    return bool(M + sure < nominal / TIMES_CAD or M - sure > nominal * TIMES_CAD)


def selected_of(problem: Problem, state: Unknowns, *families: str) -> list[Unknown]:
    """The numbers of families that are among those selected."""
    every = problem.unknowns(families)
    return [each for each in every if each.place in state.selected]


def _places(problem: Problem, state: Unknowns, *families: str) -> Int[np.ndarray, " n"]:
    """Where they are among those selected."""
    places = [each.place for each in selected_of(problem, state, *families)]
    return np.flatnonzero(np.isin(state.selected, places))


def most_likely_densities(
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


def size_of(problem: Problem, solution: Solution, family: str) -> float:
    """How large something is that was free, by restricted likelihood as well; SI."""
    value, C = sizes_of(problem, solution, family)
    chosen = {each.name for each in selected_of(problem, solution.state, family)}
    every = problem.acting.followed.disturbances
    share = np.array([each.std for each in every if each.name in chosen])
    # Numbers that are all zero still may be as large as the least deviation.
    least = np.min(np.sqrt(np.diag(C)) / share)
    guess = float(max(np.sqrt(np.mean(np.square(value / share))), least))
    return most_likely_densities([np.diag(share)], value, C, [guess])[0].value


def densities_of_waves(
    problem: Problem, solution: Solution, unknown: Sequence[str]
) -> dict[str, Density]:
    """The most likely density of every walk of which the robot file declares none.

    Args:
        problem: a recording's equations.
        solution: of these, with the waves of all walks as its last unknowns.
        unknown: groups of waves; the density of any other walk is taken as it is.
    """
    of_walks = {name: problem.unknowns([name]) for name in WALKS}
    acting = [name for name in WALKS if of_walks[name]]
    waves = [len(of_walks[name]) for name in acting]
    n, state, prior = sum(waves), solution.state, solution.prior
    std = prior.std.copy()
    std[-n:] = np.inf
    factor = prior._replace(std=std).added(solution.linear.common, state)
    R, z = factor[-1 - n : -1, -1 - n : -1], factor[-1 - n : -1, -1]
    parts = dict(zip(acting, np.split(R, np.cumsum(waves)[:-1], axis=1), strict=True))
    before = {name: of_walks[name][0].std for name in acting}
    noise = np.eye(n)
    for name in acting:
        if name not in unknown:
            noise += before[name] ** 2 * parts[name] @ parts[name].T
    found = most_likely_densities(
        [parts[name] for name in unknown],
        z + R @ state.common[-n:],
        noise,
        [before[name] for name in unknown],
    )
    return dict(zip(unknown, found, strict=True))


def with_densities(
    problem: Problem, fit: Callable[[Problem], Solution]
) -> tuple[Problem, dict[str, Density]]:
    """Take walks of which no density is declared to be as strong as is most likely.

    Args:
        problem: a recording's equations.
        fit: finds a solution of such equations.

    Returns:
        The equations, and each density that was estimated, by group.
    """
    first, robot = problem, problem.acting.followed.robot
    walk = dict(zip(WALKS, robot.momentum_walk, strict=True))
    waves = [group for group in robot.said_to_act if group in WALKS and not walk[group]]
    found = dict[str, Density]()
    for _ in range(ROUNDS if problem.walking or waves else 0):
        before, solution = found, fit(problem)
        if problem.walking:
            found = densities_of_rates(problem, solution, first)
            problem = walking_so(problem, found)
        else:
            found = densities_of_waves(problem, solution, waves)
            values = {group: each.value for group, each in found.items()}
            problem = problem._replace(acting=problem.acting.walking(values))
        if before and all(near(found[group], before[group]) for group in found):
            break
    return problem, found
