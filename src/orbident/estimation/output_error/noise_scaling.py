"""Solve with the noise, and the weights of outliers, that the residuals show."""

from collections.abc import Callable, Collection, Mapping
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from orbident import _core
from orbident.estimation.convergence import Convergence
from orbident.estimation.output_error.lasting import at_level, innovated
from orbident.estimation.output_error.problem import BySensor, Problem, Unknowns
from orbident.estimation.output_error.sensors import some_of
from orbident.estimation.output_error.shooting import TURN_AND_BIASES
from orbident.estimation.output_error.solver import Solution, solved
from orbident.recordings.long_recording import LARGE

NORMAL = 1.4826
"""Std over median absolute value, of Gaussian noise."""

HUBER = 4.0
"""Residuals beyond so many deviations count less (Huber, 1964)."""

LEAST = 1e-3
"""Noise is not found to be smaller by more than this at once."""

ROUNDS = 6

TAKEN = 0.5
"""The most of a sensor's noise that unknowns take up: what is less was not there."""

LOST = 2
"""Rounds without a solution, one after another: other weights bring none."""

SETTLED = 0.05
"""Weights that change less, relative, change no estimate."""


class Whitened(NamedTuple):
    """One sensor's residuals over the noise that was assumed."""

    values: Float[np.ndarray, "samples axes"]
    """Rows without a sample and axes that do not count are left out."""
    unknowns: float
    """How many it took to make them small."""

    @property
    def scale(self) -> float:
        """The noise over what was assumed, outliers left out."""
        size = np.abs(self.values)
        if not size.size:
            return 1.0
        inside = self.values[size <= HUBER * NORMAL * np.median(size)]
        left = max(inside.size - self.unknowns, 1.0)
        return max(float(np.sqrt(np.sum(inside**2) / left)), LEAST)

    @property
    def whiteness(self) -> float:
        """Correlation of neighbours: 0 for white noise."""
        power = np.sum(self.values**2)
        between = np.sum(self.values[:-1] * self.values[1:])
        return float(between / power) if power else 0.0


def whitened(
    weights: BySensor, residuals: BySensor, unknowns: Mapping[str, float]
) -> dict[str, Whitened]:
    """The whitened residuals of every sensor, by its name."""
    found = {}
    for name, table in residuals.items():
        rows, axes = counted(weights[name])
        values = counting(some_of(table, rows), axes)
        found[name] = Whitened(values, unknowns[name])
    return found


def counted(
    weights: Float[np.ndarray, "rows axes"],
) -> tuple[Bool[np.ndarray, " rows"], Bool[np.ndarray, " axes"]]:
    """The rows and the axes in which a sensor has samples that count."""
    seen = weights > 0
    return np.asarray(seen.any(axis=1)), np.asarray(seen.any(axis=0))


def counting(
    table: Float[np.ndarray, "rows axes"], axes: Bool[np.ndarray, " axes"]
) -> Float[np.ndarray, "rows some"]:
    """The axes that count; not copied where all do."""
    return table if axes.all() else table[:, axes]


def rescaled(weights: BySensor, scales: Mapping[str, float]) -> BySensor:
    """The weights of sensors whose noise is `scales` times as large."""
    return {
        name: weight if scales[name] == 1 else weight / scales[name]
        for name, weight in weights.items()
    }


def robust(weights: BySensor, residuals: BySensor) -> BySensor:
    """Lower the weights of outliers among the whitened residuals (Huber 1964)."""
    return {
        name: weight * np.sqrt(HUBER / np.maximum(np.abs(residuals[name]), HUBER))
        for name, weight in weights.items()
    }


def reweighted(residuals: BySensor, old: BySensor, new: BySensor) -> BySensor:
    """Residuals whitened by other weights."""
    return {
        name: table
        if new[name] is old[name]
        else table * new[name] / np.where(old[name] > 0, old[name], 1.0)
        for name, table in residuals.items()
    }


def change(old: BySensor, new: BySensor) -> float:
    """The largest relative change of a weight."""
    changes = (
        np.abs(new[name] / np.where(weight > 0, weight, 1.0) - 1)[weight > 0]
        for name, weight in old.items()
    )
    return max((float(part.max(initial=0.0)) for part in changes), default=0.0)


class Fitted(NamedTuple):
    """A recording's solution, and how well its sensors were predicted."""

    solution: Solution
    parts: dict[str, Whitened]
    """Residuals over the noise found, by sensor."""
    levels: dict[str, float]
    """The noise found, over what was assumed at first."""
    residuals: BySensor
    """Residuals at all rows over the estimated noise; zero without a sample."""
    change: float
    """The largest relative change of a weight in the last round."""
    convergence: Convergence
    """The steps of all rounds."""

    @property
    def settled(self) -> bool:
        """Whether another round would have changed no estimate."""
        return self.change < SETTLED


def fitted(
    problem: Problem,
    solution: Solution,
    least: Mapping[str, float],
    declared: Collection[str],
    progress: Callable[[], object],
    steps: int,
) -> Fitted:
    """Go on from a solution with assumed noise to the most likely one.

    Args:
        problem: a recording's equations.
        solution: of these.
        least: levels of noise by sensor, over what is assumed at first.
        declared: sensors whose noise is.
        progress: is called at every step.
        steps: at most, for the weights of each round.
    """
    unknowns = _unknowns(problem, solution.state)
    used = dict(problem.weights)
    levels = dict.fromkeys(used, 1.0)
    rounds = lost = 0
    taken: Convergence = ()
    while True:
        rounds += 1
        if rounds > 1:
            state, prior = solution.state, solution.prior
            solution = solved(problem, used, prior, state, progress, steps)
        taken += tuple(step._replace(round=rounds) for step in solution.convergence)
        lost = 0 if solution.converged else lost + 1
        lasting = at_level(problem.lasting, problem.weights, used)
        residuals, parts, new, changed = {}, {}, {}, 0.0
        # One sensor after another: tables of a long recording are large, and what is
        # done with goes at once.
        if problem.t.size >= LARGE:
            _core.give_back_memory()
        for name in used:
            plain = rescaled({name: problem.weights[name]}, levels)
            own = {name: used[name]}
            left = reweighted({name: solution.linear.residuals.pop(name)}, own, plain)
            left = innovated(problem.t, lasting, left, plain, own)
            scale = whitened(plain, left, unknowns)[name].scale
            before = levels[name]
            levels[name] = _level(before * scale, least[name], name in declared)
            left[name] = left[name] * (before / levels[name])
            plain = rescaled({name: problem.weights[name]}, levels)
            after = robust(plain, left)
            changed = max(changed, change(own, after))
            new |= after
            residuals |= left
            parts |= whitened(plain, left, unknowns)
        used = new
        if rounds == ROUNDS or lost == LOST or changed < SETTLED:
            return Fitted(solution, parts, levels, residuals, changed, taken)
        del parts, residuals


def _level(found: float, least: float, declared: bool) -> float:
    """The noise over what is assumed: declared noise that is there is no less."""
    return 1.0 if declared and TAKEN < found < 1 else max(found, least)


def _unknowns(problem: Problem, state: Unknowns) -> Mapping[str, float]:
    """About how many each sensor's residuals were made small with.

    Of the joints' corrections half: there are twice as many as their motion needs.
    """
    names = list(problem.weights)
    base = len(names) - ("joints" in names)
    share = (TURN_AND_BIASES + state.common.size) / max(base, 1)
    return {
        name: problem.weights[name].shape[1] * problem.boundaries.size
        if name == "joints"
        else share
        for name in names
    }
