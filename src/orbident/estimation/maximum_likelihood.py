"""Maximum likelihood by output error (theory: Section 6).

Momentum conservation predicts what all sensors show; the unknowns are those that make
the whitened prediction errors smallest: `beta = [M, sigma, iota]`, momentum and CM
motion, sensor biases, attitudes where segments of the recording meet (multiple
shooting), and the errors of the smoothed joint histories. The information at the
solution gives the covariance.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from jaxtyping import Float

from orbident import _core
from orbident.environment.agents import PUSH, SLOW
from orbident.estimation.estimate import Goodness, SensorFit
from orbident.estimation.found import BetaEstimate, hidden_of, prior_std
from orbident.estimation.linear_fits import Fits, InitialMomentum
from orbident.estimation.momentum_problem import OutsideMomentum
from orbident.estimation.output_error.beforehand import (
    first_momentum,
    prior_of,
    with_others,
)
from orbident.estimation.output_error.disturbance_sizes import (
    identified,
    with_densities,
)
from orbident.estimation.output_error.disturbances import (
    requested,
    start_with,
    with_disturbances,
)
from orbident.estimation.output_error.noise_scaling import Fitted, fitted
from orbident.estimation.output_error.problem import (
    Problem,
    linear,
    problem_of,
    start_of,
)
from orbident.estimation.output_error.sensitivity import (
    sensitivity,
    taken_for_zero,
    with_unseen,
)
from orbident.estimation.output_error.sensors import Sensors, sensors_of
from orbident.estimation.output_error.sharing import shared_of
from orbident.estimation.output_error.solver import STEPS, solved
from orbident.estimation.predicted import sensor_signals
from orbident.estimation.shared import Shared
from orbident.estimation.signals import Signals
from orbident.estimation.solution import (
    OUTSIDE,
    Convergence,
    Linear,
    Prior,
    Solution,
    Unknowns,
)
from orbident.estimation.unknowns import CalibrationFit, DisturbanceFit, Sensitivity
from orbident.model.minimal_sets import MinimalSets, conserved_axes
from orbident.preprocessing.delays import delays
from orbident.preprocessing.samples import Samples
from orbident.recordings.long_recording import LARGE
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot


@dataclass(frozen=True)
class Likelihood:
    """The most likely parameters, and what else was found."""

    estimate: BetaEstimate
    biases: dict[str, dict[str, float]]
    disturbances: dict[str, DisturbanceFit]
    """What acted from outside."""
    suspected: dict[str, float]
    """What may act too, by its group: how far chi-square would fall."""
    unseen: dict[str, Float[np.ndarray, " beta"]]
    """How far off `beta` could be by what acts too faintly to be seen, by its group."""
    instead: dict[str, Float[np.ndarray, " beta"]]
    """What may act in place of a torque, by its group: how far off `beta` is then."""
    sensors: dict[str, SensorFit]
    goodness: Goodness
    """The fit of all residuals over declared noise, or over estimated noise."""
    converged: bool
    settled: bool
    """Whether noise and weights of outliers no longer changed from round to round."""
    convergence: Convergence
    """The steps of the search that led to the estimate."""
    signals: Signals
    calibration: dict[str, CalibrationFit]
    """The errors of instruments that have a tolerance."""
    sensitivity: Callable[[], Sensitivity]
    """What those without a tolerance would do; it takes one more linearisation."""
    solution: Solution
    """Where the search ended with nothing acting from outside."""
    shared: Callable[[], Shared]
    """What the recording says to others of the robot."""
    given: Callable[[], OutsideMomentum | None]
    """What acted from outside has given to the momenta."""


def maximum_likelihood(
    robot: Robot,
    sets: MinimalSets,
    recording: Recording,
    samples: Samples,
    fits: Fits,
    beta: Float[np.ndarray, " beta"],
    late: Mapping[str, float],
    initial_momentum: InitialMomentum,
    progress: Callable[[], object] = lambda: None,
    steps: int = STEPS,
    others: Shared | None = None,
) -> Likelihood:
    """Fit all sensors at once.

    Args:
        robot: geometry, wheels, and the noise of its sensors where that is known.
        sets: its minimal sets.
        recording: of the free-floating robot.
        samples: of it: histories of joints and wheels, and a first attitude.
        fits: the linear fits: a first momentum.
        beta: where the search starts.
        late: by sensor, by how much its clock is behind, s, beside declared latencies.
        initial_momentum: `"at-rest"` is used; the first sample is like any other.
        progress: is called at every step.
        steps: at most, for the weights of each round; where fewer than usual find no
            least cost, and the fit is bad, it is not asked what else acts.
        others: what other recordings of the robot say; the search starts there.
    """
    sensors = sensors_of(robot, recording, delays(robot, recording, late))
    problem = problem_of(robot, sets, samples, sensors)
    outside = first_momentum(robot, sets, samples, fits, initial_momentum)
    prior = prior_of(robot, sets, problem.declared, outside, initial_momentum)
    if others is not None:
        beta, prior = others.beta, with_others(prior, others, problem.declared)
    # Linear fits are poor where a velocity is noisier than the motion.
    starts = [
        start_of(problem, samples, outside, at) for at in (beta, sets.beta(robot.theta))
    ]
    at_hand = []
    # Those of many samples are as good as they will be, and equations take long.
    if problem.t.size >= LARGE:
        _core.give_back_memory()
    else:
        here, other = (linear(problem, problem.weights, at) for at in starts)
        if other.cost < here.cost:
            here, starts = other, starts[::-1]
        at_hand = [here]
        del here, other
    least = {name: each.least / each.std for name, each in sensors.by_name.items()}
    declared = {name for name, each in sensors.by_name.items() if each.declared}

    search = _DisturbanceSearch(
        problem, prior, starts, at_hand, least, declared, progress, steps
    )
    # Without declared noise, what splines leave between samples may look slow too.
    excluded = () if declared == set(sensors.by_name) else SLOW
    asked = requested(problem, robot.said_to_act)
    if samples.pushed:
        asked = (*asked, PUSH)
    problem, density_std = with_densities(
        problem, asked, lambda problem: replace(search, problem=problem).first(asked)
    )
    search = replace(search, problem=problem)
    fit = with_disturbances(problem, search, excluded, asked, steps < STEPS)
    zeros, found, groups, plain, instead = fit
    estimate = estimate_of(found.solution, prior_std(robot, sets))
    faint = taken_for_zero(zeros)
    # Who says what acts has said that nothing else does: chance explains it.
    silent = robot.disturbances is None
    suspects = {name: each for name, each in faint.items() if silent and each.suspected}
    unseen = {name: each.unseen for name, each in faint.items() if name not in suspects}
    apart = np.reshape([*instead.values()], (-1, beta.size)).T
    off = np.hstack([apart, *(each.off for each in suspects.values())])
    covariance = estimate.covariance + off @ off.T
    return Likelihood(
        estimate=estimate._replace(covariance=covariance),
        biases=_biases(robot, sensors, found),
        disturbances=identified(problem, found.solution, groups, density_std),
        sensors={name: _sensor_fit(sensors, found, name) for name in found.parts},
        goodness=_goodness(sensors, found),
        converged=found.solution.converged,
        settled=found.settled,
        convergence=found.convergence,
        signals=sensor_signals(robot, problem, sensors, found),
        calibration=_calibration(problem, found.solution),
        sensitivity=lambda: with_unseen(sensitivity(zeros), unseen),
        solution=plain.solution,
        shared=partial(shared_of, problem, found.solution, off),
        suspected={group: each.falls for group, each in suspects.items()},
        unseen=unseen,
        instead=instead,
        given=partial(_given, problem, found.solution.state),
    )


@dataclass(frozen=True)
class _DisturbanceSearch:
    """Fits a recording with some of what may act from outside among the unknowns."""

    problem: Problem
    prior: Prior
    starts: Sequence[Unknowns]
    at_hand: list[Linear]
    """The equations at the first start, until they are used: they are large."""
    least: Mapping[str, float]
    declared: Collection[str]
    progress: Callable[[], object]
    steps: int

    def first(self, more: tuple[str, ...]) -> Solution:
        """Search from the better start, and from the other where that leads nowhere."""
        best, other = self.starts
        solution = self._from(best, more)
        return solution if solution.converged else self._from(other, more)

    def _from(self, start: Unknowns, more: tuple[str, ...]) -> Solution:
        problem, weights = self.problem, self.problem.weights
        prior, state = start_with(problem, self.prior, start, more)
        return solved(
            problem,
            weights,
            prior,
            state,
            self.progress,
            self.steps,
            self.at_hand.pop() if self.at_hand and not more else None,
        )

    def whole(self, first: Callable[[], Solution]) -> Fitted:
        """Go on with the noise that the residuals show."""
        return fitted(
            self.problem,
            first,
            self.least,
            self.declared,
            self.progress,
            self.steps,
        )


def estimate_of(solution: Solution, scale: Float[np.ndarray, " beta"]) -> BetaEstimate:
    """The part of a solution that is about `beta`."""
    n, prior, state = scale.size, solution.prior, solution.state
    of_beta = slice(OUTSIDE, OUTSIDE + n)
    # What is known beforehand of all else counts: a momentum gives the scale.
    std = prior.std.copy()
    std[of_beta] = np.inf
    factor = prior._replace(std=std).added(solution.linear.common, state)
    if state.selected.size:
        # With the calibrations first, the last rows are what is known of beta alone.
        columns = np.roll(np.arange(OUTSIDE, len(factor) - 1), state.selected.size)
        order = np.r_[:OUTSIDE, columns, len(factor) - 1]
        factor = np.asarray(np.linalg.qr(factor[:, order], mode="r"))
    C = solution.covariance[solution.linear.local :, solution.linear.local :]
    return BetaEstimate(
        values=state.beta,
        covariance=C[of_beta, of_beta],
        hidden=hidden_of(factor[-n - 1 : -1, -n - 1 : -1], scale),
    )


def _biases(
    robot: Robot, sensors: Sensors, found: Fitted
) -> dict[str, dict[str, float]]:
    """The biases at the end of the recording, estimated from all of it."""
    turning, moving = conserved_axes(robot)
    solution = found.solution
    C = solution.end.covariance(solution.covariance)
    biases = {}
    for first, name, axes in ((3, "gyro", turning), (6, "accelerometer", moving)):
        for k in axes if name in sensors.by_name else ():
            biases[f"{name}.{'xyz'[k]}"] = {
                "value": float(solution.state.local[-1, first + k]),
                "std": float(np.sqrt(max(C[first + k, first + k], 0.0))),
            }
    return biases


def _given(problem: Problem, at: Unknowns) -> OutsideMomentum | None:
    return problem.acting.given(at.beta, at.calibration, at.selected)


def _calibration(problem: Problem, solution: Solution) -> dict[str, CalibrationFit]:
    values, n = solution.state.calibration, len(solution.state.selected)
    std = np.sqrt(np.diag(solution.covariance))[-n:] if n else np.zeros(0)
    # Disturbances come after them.
    return {
        each.name: CalibrationFit(float(value), float(deviation), each.std)
        for each, value, deviation in zip(problem.declared, values, std, strict=False)
    }


def _sensor_fit(sensors: Sensors, found: Fitted, name: str) -> SensorFit:
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


def _goodness(sensors: Sensors, found: Fitted) -> Goodness:
    total = left = 0.0
    for name, part in found.parts.items():
        declared = sensors.by_name[name].declared
        level = found.levels[name] if declared else 1.0
        total += level**2 * float(np.sum(part.values**2))
        left += part.values.size - part.unknowns
    declared = any(sensors.by_name[name].declared for name in found.parts)
    return Goodness(total, left, declared)
