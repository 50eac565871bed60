"""`beta = [M, sigma, iota]` from equations that are linear in `y = [pi, phi]`.

There are more of `pi` and `phi` than base parameters that they are made of. Of all rows
of Eqs. 24 and 31 a triangular factor is left, `R y = z`, whatever their number, and

    minimise |R y(beta) - z|^2
"""

import numpy as np
from jaxtyping import Float
from scipy.linalg import block_diag
from scipy.optimize import least_squares

from orbident.estimation.found import BetaEstimate, hidden_of, prior_std
from orbident.estimation.linear_fits import Fits
from orbident.estimation.overflow import check_finite
from orbident.model.minimal_sets import MinimalSets
from orbident.robot.description import Robot

PRECISION = 1e-15
"""Relative, at which MINPACK stops."""

EVALUATIONS = 200
"""The most that a fit may take: those of 20 random robots took 5 to 20."""


def beta_of_fits(robot: Robot, sets: MinimalSets, fits: Fits) -> BetaEstimate:
    """Nonlinear least squares from the nominal values, as if all noise were white."""
    std = [fit.scatter for fit in (fits.pi, fits.phi)]
    R = block_diag(fits.pi.factor / std[0], fits.phi.factor / std[1])
    z = np.concatenate([fits.pi.target / std[0], fits.phi.target / std[1]])
    nominal, wide = sets.beta(robot.theta), prior_std(robot, sets)
    return nonlinear_fit(sets, nominal, wide, np.asarray(R), z)


def nonlinear_fit(
    sets: MinimalSets,
    nominal: Float[np.ndarray, " beta"],
    wide: Float[np.ndarray, " beta"],
    R: Float[np.ndarray, "y y"],
    z: Float[np.ndarray, " y"],
) -> BetaEstimate:
    """`beta` of `R y(beta) = z`; what this does not tell stays nominal.

    Raises:
        InputError: the equations overflow.
    """
    check_finite(R, z)

    # x: beta's distance from the nominal values, over the robot's scale.
    def residual(x: Float[np.ndarray, " beta"]) -> Float[np.ndarray, " rows"]:
        y = np.concatenate(sets.pi_and_phi(nominal + wide * x))
        return np.concatenate([R @ y - z, x])

    def slopes(x: Float[np.ndarray, " beta"]) -> Float[np.ndarray, "rows beta"]:
        J = np.vstack(sets.derivatives(nominal + wide * x))
        return np.vstack([R @ J * wide, np.eye(x.size)])

    found = least_squares(
        residual,
        np.zeros(nominal.size),
        slopes,  # pyright: ignore[reportArgumentType]: its stubs know names only
        method="lm",
        xtol=PRECISION,
        ftol=PRECISION,
        gtol=PRECISION,
        max_nfev=EVALUATIONS,
    )
    J = slopes(found.x)
    root = np.linalg.inv(np.linalg.qr(J, mode="r")) * wide[:, None]
    hidden = hidden_of(J[: -wide.size] / wide, wide)
    return BetaEstimate(nominal + wide * found.x, root @ root.T, hidden)
