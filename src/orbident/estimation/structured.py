"""`beta = [M, sigma, iota]` from the linear equations, their structure kept.

The rows of Eqs. 24 and 31 are linear in `pi` and `phi`, and there are more of these
than base parameters that they are made of. With the triangular factors of all rows, in
which momentum, CM velocity and the accelerometer's bias are eliminated,

    minimise |R_pi pi(beta) - z_pi|^2 / s_h^2 + |R_phi phi(beta) - z_phi|^2 / s_v^2

whatever the number of samples; `s_h` and `s_v` are the scatter of the residuals.
"""

import numpy as np
from jaxtyping import Float
from scipy.optimize import least_squares

from orbident.estimation.found import BetaEstimate, hidden_of
from orbident.estimation.least_squares import Fits
from orbident.estimation.prior import prior_std
from orbident.estimation.triangular import LinearFit
from orbident.regressors.derivatives import derivatives_of_beta, sets_of_beta
from orbident.regressors.minimal_sets import MinimalSets
from orbident.robot.description import Robot

ROUNDING = 1e-13
"""Of the right-hand side: without noise the scatter is no smaller."""

PRECISION = 1e-15
"""Relative, at which MINPACK stops."""


def structured(robot: Robot, sets: MinimalSets, fits: Fits) -> BetaEstimate:
    """Nonlinear least squares, from the nominal values.

    Args:
        robot: its nominal inertia is where the search starts.
        sets: its minimal sets.
        fits: the triangular factors of a recording.
    """
    wide, nominal = prior_std(robot, sets), sets.beta(robot.theta)
    s_h, s_v = _scatter(fits.pi), _scatter(fits.phi)

    # x: beta's distance from the nominal values, over the robot's scale.
    def residual(x: Float[np.ndarray, " beta"]) -> Float[np.ndarray, " rows"]:
        pi, phi = sets_of_beta(sets, nominal + wide * x)
        turning = (fits.pi.factor @ pi - fits.pi.target) / s_h
        moving = (fits.phi.factor @ phi - fits.phi.target) / s_v
        return np.concatenate([turning, moving, x])

    def slopes(x: Float[np.ndarray, " beta"]) -> Float[np.ndarray, "rows beta"]:
        dpi, dphi = derivatives_of_beta(sets, nominal + wide * x)
        turning, moving = fits.pi.factor @ dpi / s_h, fits.phi.factor @ dphi / s_v
        return np.vstack([turning * wide, moving * wide, np.eye(x.size)])

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
