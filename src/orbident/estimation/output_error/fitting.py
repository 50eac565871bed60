"""Solve with the noise, and the weights of outliers, that the residuals show."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

from orbident.estimation.output_error.chain import Problem, State
from orbident.estimation.output_error.residuals import (
    Residuals,
    Whitened,
    change,
    rescaled,
    reweighted,
    robust,
    whitened,
)
from orbident.estimation.output_error.solve import Prior, Solution, solved
from orbident.estimation.output_error.unknowns import LOCAL

ROUNDS = 6

SETTLED = 0.05
"""Weights that change less, relative, change no estimate."""


class Fitted(NamedTuple):
    """A recording's solution, and how well its sensors were predicted."""

    solution: Solution
    parts: dict[str, Whitened]
    """Residuals over the noise found, by sensor."""
    levels: dict[str, float]
    """The noise found, over what was assumed at first."""
    residuals: Residuals
    """At all rows, over the noise found; zero where there was no sample."""


def fitted(
    problem: Problem,
    prior: Prior,
    state: State,
    least: Mapping[str, float],
    progress: Callable[[], object],
) -> Fitted:
    """From a state to the most likely one; `least` levels of noise by sensor."""
    unknowns = _unknowns(problem, state)
    plain = used = problem.chart.shown
    levels = dict.fromkeys(plain.weights, 1.0)
    rounds = 0
    while True:
        rounds += 1
        chart = problem.chart._replace(shown=used)
        solution = solved(problem._replace(chart=chart), prior, state, progress)
        state = solution.state
        residuals = reweighted(solution.linear.residuals, used, plain)
        parts = whitened(plain, residuals, unknowns)
        scales = {
            name: max(part.scale, least[name] / levels[name])
            for name, part in parts.items()
        }
        levels = {name: level * scales[name] for name, level in levels.items()}
        before, plain = plain, rescaled(plain, scales)
        residuals = reweighted(residuals, before, plain)
        before, used = used, robust(plain, residuals)
        if rounds == ROUNDS or change(before, used) < SETTLED:
            parts = whitened(plain, residuals, unknowns)
            return Fitted(solution, parts, levels, residuals)


def _unknowns(problem: Problem, state: State) -> Mapping[str, float]:
    """About how many each sensor's residuals were made small with.

    Of the joints' corrections half: there are twice as many as their motion needs.
    """
    names = list(problem.chart.shown.weights)
    base = len(names) - ("joints" in names)
    corrections = state.local.shape[1] - LOCAL
    share = (LOCAL + state.common.size) / max(base, 1)
    boundaries = len(set(problem.chart.t))
    return {
        name: corrections * boundaries / 2 if name == "joints" else share
        for name in names
    }
