"""Least squares of Eqs. 24 and 31: each for itself, or all with their noise.

The paper's method takes Eq. 24 for `pi` and Eq. 31 for `phi`. With the noise, biases
and drift of the sensors, the rows are those of the recursive filter (the core's
`information_filter.hpp`). They depend on the estimate and are made again with it, until
it has settled.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from orbident.estimation.base_parameters import (
    beta_of_fits,
    nonlinear_fit,
    parameters_of_fits,
    prior_std,
)
from orbident.estimation.estimate import (
    Estimate,
    Goodness,
    Progress,
    biases_of_sensors,
    estimate_of_beta,
    rms_of_equations,
)
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.quantities import Quantity
from orbident.estimation.recursive.filter import Extended, GaussianPrior, State
from orbident.estimation.recursive.filter_input import none_complete, pieces_of
from orbident.estimation.solution import SMALL, Step
from orbident.preprocessing.stretches import Piece


@dataclass(frozen=True)
class LeastSquares:
    """Separate linear fits, and the mass by Eq. 32.

    The deviations are those of white noise of unknown size: no bias, no drift, and
    regressors without noise.
    """

    name: str = "least-squares"

    def estimate(self, problem: MomentumProblem, progress: Progress) -> Estimate:
        """Take the linear fits as they are."""
        mass = problem.linear_mass
        M = Quantity(mass.value, mass.std)
        progress(1.0)
        return Estimate(
            parameters=parameters_of_fits(problem.sets, problem.fits, mass),
            mass=M,
            masses={"Eq. 32": M},
            rms=rms_of_equations(problem),
            biases=_biases(problem),
        )


def _biases(problem: MomentumProblem) -> dict[str, dict[str, float]]:
    """That of the accelerometer, where the velocity was integrated from it."""
    if not problem.samples.biased:
        return {}
    moving, phi = problem.sets.regressors.velocity_axes, problem.fits.phi
    names = [f"accelerometer.{'xyz'[k]}" for k in moving]
    values, stds = phi.nuisances[len(moving) :], phi.nuisances_std[len(moving) :]
    return {
        name: {"value": float(value), "std": float(std)}
        for name, value, std in zip(names, values, stds, strict=True)
    }


PASSES = 30
"""Passes through the recording, at most: those of small free-flyers took 4 to 12."""


@dataclass(frozen=True)
class Structured:
    """Nonlinear least squares of all equations for `[M, sigma, iota]`."""

    name: str = "structured"

    def estimate(self, problem: MomentumProblem, progress: Progress) -> Estimate:
        """Make the equations and solve them, again and again.

        Raises:
            InputError: there is no complete sample, or the noise of the base rate is
                not known.
        """
        robot, sets = problem.robot, problem.sets
        wide, nominal = prior_std(robot, sets), sets.beta(robot.theta)
        noise, pieces = pieces_of(problem)
        kalman = Extended.of(robot, noise)
        found, taken = beta_of_fits(robot, sets, problem.fits), list[Step]()
        while True:
            before = GaussianPrior(found.values, np.diag(1 / wide))
            state, squares, rows = _gathered(
                kalman, before, problem.h_cm, pieces(), problem.samples.source
            )
            R, z = state.R_z[:, :-1], state.R_z[:, -1]
            found = nonlinear_fit(sets, nominal, wide, R, z, before.beta)
            std = np.sqrt(np.diag(found.covariance))
            size = float(np.max(np.abs(found.values - before.beta) / std))
            y = np.concatenate(sets.pi_and_phi(found.values))
            squares += float(np.sum(np.square(R @ y - z)))
            taken.append(Step(squares, size))
            progress(len(taken) / PASSES)
            if size < SMALL or len(taken) == PASSES:
                break
        goodness = Goodness(squares, rows - nominal.size, noise.declared)
        # Sensors that are worse than declared make the estimate as much worse.
        scaled = found.covariance * max(goodness.per_dof, 1.0)
        found = found._replace(covariance=scaled)
        rms = rms_of_equations(problem)
        return replace(
            estimate_of_beta(problem, found, "structured", rms, goodness),
            biases=biases_of_sensors(
                problem, kalman.biases(state, found.values, scaled)
            ),
            converged=size < SMALL,
            convergence=tuple(taken),
        )


def _gathered(
    kalman: Extended,
    before: GaussianPrior,
    h_cm: Float[np.ndarray, "3"] | None,
    pieces: Iterator[Piece],
    source: str,
) -> tuple[State, float, int]:
    """What all samples say, linearised about the estimate before."""
    state, squares, rows = None, 0.0, 0
    for t, samples in pieces:
        if t.size:
            state = state or kalman.begun(before, samples[0], h_cm)
            state, own, count = kalman.gathered(state, t, samples)
            squares, rows = squares + own, rows + count
    if state is None:
        raise none_complete(source)
    return state, squares, rows
