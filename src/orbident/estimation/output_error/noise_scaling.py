"""Solve with the noise, and the weights of outliers, that the residuals show."""

from collections.abc import Callable, Collection, Mapping
from functools import partial
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from orbident.estimation.estimate import Goodness, SensorFit, whiteness
from orbident.estimation.output_error.looseness import TURN_AND_BIASES
from orbident.estimation.output_error.problem import Problem
from orbident.estimation.output_error.sensors import (
    RATE_WALK,
    TORQUES,
    Sensors,
    at_level,
    innovated,
    some_of,
)
from orbident.estimation.output_error.solver import BAD, solved
from orbident.estimation.output_error.walking_rates import free_running
from orbident.estimation.signals import SIGNAL_UNITS, Signal, Signals
from orbident.estimation.solution import BySensor, Convergence, Solution
from orbident.gaussian import OF_MEDIAN
from orbident.preprocessing.histories import Columns
from orbident.recordings.long_recording import spare_memory
from orbident.robot.description import Robot
from orbident.robot.units import BY_KIND, OF_A_JOINT, TORQUE_OF_A_JOINT, si_unit

OF_JOINTS = {"joints": OF_A_JOINT, TORQUES: TORQUE_OF_A_JOINT}
"""What sensors of joints show, by their names: its dimension."""

HUBER = 4.0
"""Residuals beyond so many deviations count less (Huber, 1964)."""

LEAST = 1e-3
"""Noise is not found to be smaller by more than this at once."""

ROUNDS = 6
"""The most solutions, each with the weights that the one before it asks for."""

TAKEN = 0.5
"""The most of a sensor's noise that unknowns take up: what is less was not there."""

SETTLED = 0.05
"""Weights that change less, relative, change no estimate."""

BETWEEN = 4
"""Steps of a search between two changes of the weights, at most: where a model fits it
takes fewer, and where it does not, those that follow move little."""


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
        inside = self.values[size <= HUBER * OF_MEDIAN * np.median(size)]
        left = max(inside.size - self.unknowns, 1.0)
        return max(float(np.sqrt(np.sum(inside**2) / left)), LEAST)

    @property
    def whiteness(self) -> float:
        """Correlation of neighbours: 0 for white noise."""
        return whiteness(self.values)


def is_bad(problem: Problem, cost: float) -> bool:
    """Whether samples leave far more than noise does, with that which was assumed."""
    return cost > BAD * sum(int((x > 0).sum()) for x in problem.weights.values())


def whitened(
    weights: Float[np.ndarray, "rows axes"],
    residuals: Float[np.ndarray, "rows axes"],
    unknowns: float,
) -> Whitened:
    """The whitened residuals of a sensor."""
    rows, axes = that_count(weights)
    return Whitened(of_axes(some_of(residuals, rows), axes), unknowns)


def that_count(
    weights: Float[np.ndarray, "rows axes"],
) -> tuple[Bool[np.ndarray, " rows"], Bool[np.ndarray, " axes"]]:
    """The rows and the axes in which a sensor has samples that count."""
    seen = weights > 0
    return np.asarray(seen.any(axis=1)), np.asarray(seen.any(axis=0))


def of_axes(
    table: Float[np.ndarray, "rows axes"], axes: Bool[np.ndarray, " axes"]
) -> Float[np.ndarray, "rows some"]:
    """The axes that count; not copied where all do."""
    return table if axes.all() else table[:, axes]


def robust(
    weights: Float[np.ndarray, "rows axes"], residuals: Float[np.ndarray, "rows axes"]
) -> Float[np.ndarray, "rows axes"]:
    """Lower the weights of outliers among the whitened residuals (Huber 1964)."""
    # What does not count may have no residual that is a number.
    return weights * np.sqrt(HUBER / np.fmax(np.abs(residuals), HUBER))


def reweighted(
    residuals: Float[np.ndarray, "rows axes"],
    old: Float[np.ndarray, "rows axes"],
    new: Float[np.ndarray, "rows axes"],
) -> Float[np.ndarray, "rows axes"]:
    """Residuals whitened by other weights."""
    return residuals * new / np.where(old > 0, old, 1.0)


def change(
    old: Float[np.ndarray, "rows axes"], new: Float[np.ndarray, "rows axes"]
) -> float:
    """The largest relative change of a weight."""
    seen = old > 0
    return float(np.max(np.abs(new[seen] / old[seen] - 1), initial=0.0))


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
    assumed: float
    """The cost with the noise that was assumed."""
    convergence: Convergence
    """The steps of all rounds."""

    @property
    def settled(self) -> bool:
        """Whether another round would have changed no estimate."""
        return self.change < SETTLED

    def predicted(self, problem: Problem, name: str) -> Columns:
        """What a sensor would show at the rows, by axis; NaN where it showed nothing.

        Nothing at all where there is no such sensor.
        """
        if name not in problem.weights:
            return ()
        weights, level = problem.weights[name], self.levels[name]
        std = np.divide(level, weights, where=weights > 0, out=0 * weights)
        return tuple((problem.samples[name] - self.residuals[name] * std).T)


def fitted(
    problem: Problem,
    first: Callable[[], Solution],
    least: Mapping[str, float],
    declared: Collection[str],
    progress: Callable[[], object],
    steps: int,
    hasty: bool,
) -> Fitted:
    """Go on from a solution with assumed noise to the most likely one.

    Args:
        problem: a recording's equations.
        first: finds that solution, of which nothing else is to hold the rows.
        least: levels of noise by sensor, over what is assumed at first.
        declared: sensors whose noise is.
        progress: is called at every step.
        steps: at most, for the weights of each round.
        hasty: whether a first search without a solution is enough.
    """
    solution = first()
    assumed = solution.cost
    levels = dict.fromkeys(problem.weights, 1.0)
    rounds, whole = 0, True
    taken: Convergence = ()
    while True:
        spare_memory(problem.t.size)
        rounds += 1
        taken += tuple(step._replace(round=rounds) for step in solution.convergence)
        before, levels, used, changed = levels, {}, {}, 0.0
        unknowns = _unknowns(problem, solution)
        for name in problem.weights:
            levels[name], used[name] = _reweighed(
                problem,
                solution,
                name,
                before[name],
                unknowns[name],
                partial(_level, least=least[name], declared=name in declared),
            )
            changed = max(changed, change(solution.weights[name], used[name]))
        ends = changed < SETTLED and (whole or solution.converged)
        vain = hasty and whole and not solution.converged
        if ends or vain or rounds == ROUNDS:
            break
        whole = changed < SETTLED or rounds == ROUNDS - 1
        state, prior = solution.state, solution.prior
        # Its rows take as much memory as those of the next one.
        del solution
        spare_memory(problem.t.size)
        few = steps if whole else min(steps, BETWEEN)
        solution = solved(problem, used, prior, state, progress, few)
    del used
    spare_memory(problem.t.size)
    residuals = {
        name: _over_noise(problem, solution, name, before[name])
        * (before[name] / level)
        for name, level in levels.items()
    }
    # They say all that the solution's own residuals do.
    linear = solution.linear._replace(residuals={})
    solution = solution._replace(linear=linear)
    parts = {
        name: whitened(problem.weights[name], table, unknowns[name])
        for name, table in residuals.items()
    }
    return Fitted(solution, parts, levels, residuals, changed, assumed, taken)


def _reweighed(
    problem: Problem,
    solution: Solution,
    name: str,
    before: float,
    unknowns: float,
    level_of: Callable[[float], float],
) -> tuple[float, Float[np.ndarray, "rows axes"]]:
    """The level of a sensor's noise, and what its samples weigh then."""
    left = _over_noise(problem, solution, name, before)
    scale = whitened(problem.weights[name], left, unknowns).scale
    level = level_of(before * scale)
    return level, robust(problem.weights[name] / level, left * (before / level))


def _over_noise(
    problem: Problem, solution: Solution, name: str, level: float
) -> Float[np.ndarray, "rows axes"]:
    """Residuals of a sensor over `level` times its assumed noise; outliers in full."""
    used, plain = solution.weights[name], problem.weights[name]
    left = solution.linear.residuals[name]
    if used is not plain:
        plain = plain / level
        left = reweighted(left, used, plain)
    lasting = at_level(problem.lasting, problem.weights, solution.weights)
    if name == "attitude" and lasting[0, :, RATE_WALK].any():
        over = np.where(plain > 0, plain, 1.0)
        left = free_running(problem, solution.state, left / over) * over
    own = {name: left}, {name: plain}, {name: used}
    return innovated(problem.t, lasting, *own)[name]


def _level(found: float, least: float, declared: bool) -> float:
    """The noise over what is assumed: declared noise that is there is no less."""
    return 1.0 if declared and TAKEN < found < 1 else max(found, least)


def _unknowns(problem: Problem, solution: Solution) -> dict[str, float]:
    """About how many each sensor's residuals were made small with.

    What is known beforehand of common unknowns makes no residual small: of `n`, with
    the information `P` beforehand and the covariance `C`, samples tell `n - tr(P C)`
    (Spiegelhalter 2002), of which sensors of the base have even shares.
    """
    n, prior, state = solution.state.common.size, solution.prior, solution.state
    before = prior.added(np.zeros((n + 1, n + 1)), state)[:-1, :-1]
    told = n - float(np.sum((before @ solution.covariance[-n:, -n:]) * before))
    base = [name for name in problem.weights if name != "joints"]
    shares = dict.fromkeys(base, (TURN_AND_BIASES + told) / max(len(base), 1))
    return {"joints": _of_encoders(problem, solution)} | shares


def _of_encoders(problem: Problem, solution: Solution) -> float:
    """About how many corrections made residuals of encoders small.

    A sample takes up the part of one that is its leverage, the variance of the position
    over its own: where the base tells how joints moved, little. The meeting boundary
    stands for all. Half of all is the most: they are twice as many as motion needs.
    """
    weights = solution.weights.get("joints")
    if weights is None:
        return 0.0
    joints, local = problem.loose.corrected.astype(int), solution.linear.local
    first = local - 2 * joints.size
    variance = np.diag(solution.covariance)[first : local - joints.size]
    samples = np.count_nonzero(weights, axis=0)[joints]
    taken = samples * weights.max(axis=0)[joints] ** 2 * variance
    return float(np.sum(np.minimum(taken, problem.boundaries.size)))


def sensor_signals(
    robot: Robot, problem: Problem, sensors: Sensors, found: Fitted
) -> Signals:
    """What maximum likelihood predicts that every sensor shows.

    Args:
        robot: the names and units of its joints.
        problem: all equations.
        sensors: with the noise that was assumed.
        found: residuals, and the noise that they show.
    """
    signals = []
    for name, weights in problem.weights.items():
        seen, counts = that_count(weights)
        if not seen.any():
            # As encoders of joints that never move.
            continue
        std = sensors.by_name[name].std * found.levels[name]
        if name == TORQUES:
            # Means over intervals, most of which are as long.
            std /= float(np.median(weights[weights > 0])) * sensors.by_name[name].std
        error = of_axes(some_of(found.residuals[name], seen), counts) * std
        if name == "attitude":
            measured = error
        else:
            measured = of_axes(some_of(problem.samples[name], seen), counts)
        of_joints = BY_KIND.get(OF_JOINTS.get(name, ""))
        labels = robot.joint_names if of_joints else tuple("xyz")
        kinds = [si_unit(of_joints[x.kind]) for x in robot.joints if of_joints]
        units = kinds or 3 * [SIGNAL_UNITS[name]]
        signals.append(
            Signal(
                name=name,
                axes=tuple(np.array(labels, dtype=object)[counts]),
                units=tuple(np.array(units, dtype=object)[counts]),
                t=some_of(problem.t, seen),
                measured=measured,
                predicted=measured - error,
                std=std,
            )
        )
    return tuple(signals)


def fit_of_sensor(sensors: Sensors, found: Fitted, name: str) -> SensorFit:
    """How well a sensor was predicted."""
    sensed, part = sensors.by_name[name], found.parts[name]
    noise = sensed.std * found.levels[name]
    size = part.values.size
    rms = float(np.sqrt(np.mean(part.values**2))) if size else np.nan
    return SensorFit(
        rms=rms * noise,
        noise=noise,
        declared=sensed.std if sensed.declared else np.nan,
        whiteness=part.whiteness,
        samples=len(part.values),
    )


def goodness_of(sensors: Sensors, found: Fitted) -> Goodness:
    """How large all residuals are, by the noise that is declared of each sensor."""
    total = left = 0.0
    for name, part in found.parts.items():
        declared = sensors.by_name[name].declared
        level = found.levels[name] if declared else 1.0
        total += level**2 * float(np.sum(part.values**2))
        left += part.values.size - part.unknowns
    declared = any(sensors.by_name[name].declared for name in found.parts)
    return Goodness(total, left, declared)
