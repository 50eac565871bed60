"""`beta = [M, sigma, iota]` from the equations that are linear in `y = [pi, phi]`.

There are more of `pi` and `phi` than base parameters that they are made of. Of all rows
of Eqs. 24 and 31 a triangular factor is left, `R y = z`, whatever their number, and

    minimise |R y(beta) - z|^2

In `beta_of_fits` all rows have white noise, which their residuals tell. In `structured`
they have that of the sensors, whose biases and drift are unknowns: the equations of
`estimation.recursive`, which depend on the estimate and are made again with it.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.linalg import block_diag
from scipy.optimize import least_squares

from orbident.estimation.found import BetaEstimate, hidden_of
from orbident.estimation.least_squares import Fits
from orbident.estimation.prior import prior_std
from orbident.estimation.recursive.filter import Extended
from orbident.estimation.recursive.given import given_of
from orbident.estimation.recursive.prior import Prior
from orbident.estimation.triangular import LinearFit
from orbident.model.derivatives import derivatives_of_beta, sets_of_beta
from orbident.model.minimal_sets import MinimalSets
from orbident.preprocessing.samples import Samples
from orbident.robot.description import Robot

ROUNDING = 1e-13
"""Of the right-hand side: without noise the scatter is no smaller."""

PRECISION = 1e-15
"""Relative, at which MINPACK stops."""

PASSES = 10
"""Through the recording, at most."""

SETTLED = 0.01
"""Standard deviations: an estimate that moved less has settled."""


class Structured(NamedTuple):
    """An estimate from all equations."""

    estimate: BetaEstimate
    biases: dict[str, dict[str, float]]
    """Of gyro (rad/s) and accelerometer (m/s^2): value and std."""
    chi2_per_dof: float
    consistent: bool
    """Whether the equations hold within the sensors' declared noise."""
    settled: bool
    """Whether another pass through the recording would leave the estimate as it is."""


def structured(
    robot: Robot,
    sets: MinimalSets,
    samples: Samples,
    start: BetaEstimate,
    h_cm: Float[np.ndarray, "3"] | None,
) -> Structured:
    """Nonlinear least squares of all equations, biases and drift of the sensors too.

    Args:
        robot: with the noise of its sensors, where that is known.
        sets: its minimal sets.
        samples: of a recording.
        start: where the equations are first made.
        h_cm: the momentum where it is known, inertial axes, N m s.

    Raises:
        InputError: the noise of the base rate is not known.
    """
    wide, nominal = prior_std(robot, sets), sets.beta(robot.theta)
    t, every, noise = given_of(robot, samples)
    kalman = Extended.of(robot, noise)
    found, passes = start, 0
    while True:
        before, passes = Prior(found.values, np.diag(1 / wide)), passes + 1
        state = kalman.begun(before, every[0], h_cm)
        state, squares, rows = kalman.gathered(state, t, every)
        R, z = state.R_z[:, :-1], state.R_z[:, -1]
        found = _best(sets, nominal, wide, R, z)
        moved = np.abs(found.values - before.beta) / np.sqrt(np.diag(found.covariance))
        settled = bool(moved.max() < SETTLED)
        if settled or passes == PASSES:
            break
    y = np.concatenate(sets_of_beta(sets, found.values))
    squares += np.sum(np.square(R @ y - z))
    chi2_per_dof = float(squares / max(rows - nominal.size, 1))
    # Sensors that are worse than declared make the estimate as much worse.
    scaled = found.covariance * max(chi2_per_dof, 1.0)
    found = found._replace(covariance=scaled)
    biases = kalman.biases(state, found.values, scaled)
    consistent = noise.explains(chi2_per_dof)
    return Structured(found, biases, chi2_per_dof, consistent, settled)


def beta_of_fits(robot: Robot, sets: MinimalSets, fits: Fits) -> BetaEstimate:
    """Nonlinear least squares, from the nominal values.

    Args:
        robot: its nominal inertia is where the search starts.
        sets: its minimal sets.
        fits: the triangular factors of a recording.
    """
    std = [_scatter(fit) for fit in (fits.pi, fits.phi)]
    R = block_diag(fits.pi.factor / std[0], fits.phi.factor / std[1])
    z = np.concatenate([fits.pi.target / std[0], fits.phi.target / std[1]])
    return _best(sets, sets.beta(robot.theta), prior_std(robot, sets), np.asarray(R), z)


def _best(
    sets: MinimalSets,
    nominal: Float[np.ndarray, " beta"],
    wide: Float[np.ndarray, " beta"],
    R: Float[np.ndarray, "y y"],
    z: Float[np.ndarray, " y"],
) -> BetaEstimate:
    """`beta` of `R y(beta) = z`; what this does not tell stays nominal."""

    # x: beta's distance from the nominal values, over the robot's scale.
    def residual(x: Float[np.ndarray, " beta"]) -> Float[np.ndarray, " rows"]:
        y = np.concatenate(sets_of_beta(sets, nominal + wide * x))
        return np.concatenate([R @ y - z, x])

    def slopes(x: Float[np.ndarray, " beta"]) -> Float[np.ndarray, "rows beta"]:
        J = np.vstack(derivatives_of_beta(sets, nominal + wide * x))
        return np.vstack([R @ J * wide, np.eye(x.size)])

    found = least_squares(
        residual,
        np.zeros(nominal.size),
        slopes,  # pyright: ignore[reportArgumentType]: its stubs know names only
        method="lm",
        xtol=PRECISION,
        ftol=PRECISION,
        gtol=PRECISION,
    )
    J = slopes(found.x)
    root = np.linalg.inv(np.linalg.qr(J, mode="r")) * wide[:, None]
    hidden = hidden_of(J[: -wide.size] / wide, wide)
    return BetaEstimate(nominal + wide * found.x, root @ root.T, hidden)


def _scatter(fit: LinearFit) -> float:
    return max(fit.rms, ROUNDING * float(np.linalg.norm(fit.target)))
