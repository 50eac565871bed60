"""How large what acts from outside was identified to be.

Its numbers are among the common unknowns that a solution selects.
"""

from collections.abc import Collection, Iterator, Mapping

import numpy as np
from jaxtyping import Float, Int

from orbident.estimation.output_error.forms import Disturbance
from orbident.estimation.output_error.problem import Problem
from orbident.estimation.output_error.walks import WALKS
from orbident.estimation.solution import OUTSIDE, Solution, Unknowns
from orbident.estimation.unknowns import DisturbanceFit


def identified(
    problem: Problem,
    solution: Solution,
    groups: Collection[str],
    density_std: Mapping[str, float],
) -> dict[str, DisturbanceFit]:
    """What was freed, by its name; a walk by its density.

    Args:
        problem: a recording's equations.
        solution: of these.
        groups: that were freed.
        density_std: the deviations of densities that were estimated, by their groups.
    """
    fits = {}
    for group in groups:
        value, C = sizes_of(problem, solution, group)
        std, shift = np.sqrt(np.diag(C)), _shift(problem, solution, group)
        if group in WALKS:
            wave = next(members(problem, group))
            deviation = density_std.get(group, 0.0)
            fits[group] = DisturbanceFit(group, wave.unit, wave.std, deviation, shift)
            continue
        for k, each in enumerate(members(problem, group)):
            fits[each.name] = DisturbanceFit(
                group, each.unit, float(value[k]), float(std[k]), shift
            )
    return fits


def _shift(problem: Problem, solution: Solution, group: str) -> float:
    """If `g` is zero, `beta` changes by `-C_bg C_gg^-1 g`."""
    value, C_gg = sizes_of(problem, solution, group)
    C, state = solution.covariance, solution.state
    first = len(C) - state.common.size + OUTSIDE
    beta = np.arange(first, first + state.beta.size)
    here = len(C) - state.selected.size + _selected(problem, state, group)
    change = C[np.ix_(beta, here)] @ np.linalg.solve(C_gg, value)
    return float(np.max(np.abs(change) / np.sqrt(np.diag(C)[beta])))


def members(problem: Problem, group: str) -> Iterator[Disturbance]:
    """The numbers of a group."""
    return (each for each in problem.acting.disturbances if each.group == group)


def places_of(problem: Problem, names: Collection[str]) -> Float[np.ndarray, " n"]:
    """The places of what has these names, among all that can be an unknown.

    A name is that of a group of disturbances or of an instrument's error.
    """
    errors = [each.place for each in problem.calibrations if each.name in names]
    if len(errors) == len({*names}):
        # What may act takes some 3 kB a row to work out.
        return np.array(errors, float)
    acting = zip(problem.acting.disturbances, problem.acting.places, strict=True)
    return np.array([*errors, *(k for each, k in acting if each.group in names)], float)


def _selected(problem: Problem, state: Unknowns, group: str) -> Int[np.ndarray, " n"]:
    """Where the numbers of a group are among those selected."""
    return np.flatnonzero(np.isin(state.selected, places_of(problem, [group])))


def sizes_of(
    problem: Problem, solution: Solution, group: str
) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, "n n"]]:
    """The numbers of a group that was freed, SI, and their covariance."""
    state = solution.state
    which = _selected(problem, state, group)
    here = len(solution.covariance) - state.selected.size + which
    return state.calibration[which], solution.covariance[np.ix_(here, here)]
