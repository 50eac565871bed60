"""What a method found, in all three descriptions, and what it left undetermined."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.linalg import block_diag

from orbident.estimation.linear_fits import Fits
from orbident.estimation.mass import Mass
from orbident.estimation.prior_std import WIDE, prior_std
from orbident.estimation.propagation import base_parameters
from orbident.estimation.triangular import UNSEEN
from orbident.model.derivatives import derivatives_of_beta, sets_of_beta
from orbident.model.minimal_sets import MinimalSets
from orbident.robot.description import Robot

RANK = 1e-10
"""Singular values over the largest: rounding leaves 1e-15, integration 1e-13."""

UNSURE = 1.0
"""Times the robot's own scale: a parameter less sure than this is not determined."""


class BetaEstimate(NamedTuple):
    """The free-flying base parameters `[M, sigma, iota]`."""

    values: Float[np.ndarray, " beta"]
    covariance: Float[np.ndarray, "beta beta"]
    hidden: Float[np.ndarray, "beta hidden"]
    """Columns: changes that nothing in the recording shows."""

    @property
    def mass(self) -> tuple[float, float]:
        """`M` and its standard deviation, kg."""
        return float(self.values[0]), float(np.sqrt(self.covariance[0, 0]))


def hidden_of(
    factor: Float[np.ndarray, "_ beta"], scale: Float[np.ndarray, " beta"]
) -> Float[np.ndarray, "beta hidden"]:
    """Directions that a factor of the information does not see, but for rounding.

    Args:
        factor: of what is known of changes of `beta`, without a prior.
        scale: of `beta`.
    """
    _, s, Vt = np.linalg.svd(factor * scale, full_matrices=True)
    seen = np.zeros(len(Vt), dtype=bool)
    seen[: s.size] = s > RANK * s.max(initial=0.0)
    return scale[:, None] * Vt[~seen].T


class Known(NamedTuple):
    """A set of parameters; meaningless where not `determined`."""

    values: Float[np.ndarray, " n"]
    covariance: Float[np.ndarray, "n n"]
    determined: Bool[np.ndarray, " n"]


class EstimatedParameters(NamedTuple):
    """The three descriptions."""

    pi: Known
    phi: Known
    base: Known
    covariance: Float[np.ndarray, "n n"]
    """The covariance of `[pi, phi]`."""


def found_linear(sets: MinimalSets, fits: Fits, mass: Mass) -> EstimatedParameters:
    """Combine separate fits of `pi` and `phi`, and the mass that follows from both."""
    pi, phi = (
        Known(fit.values, fit.covariance, fit.determined) for fit in (fits.pi, fits.phi)
    )
    base = base_parameters(sets, fits.pi, fits.phi, mass)
    both = np.asarray(block_diag(pi.covariance, phi.covariance))
    return EstimatedParameters(pi, phi, Known(*base), both)


def found_beta(
    robot: Robot, sets: MinimalSets, estimate: BetaEstimate
) -> EstimatedParameters:
    """Derive `pi` and `phi` from the base parameters that they are made of."""
    beta, C, hidden = estimate
    scale = prior_std(robot, sets)
    prior = np.square(scale)
    pi, phi = sets_of_beta(sets, beta)
    dpi, dphi = derivatives_of_beta(sets, beta)

    def known(values: np.ndarray, J: np.ndarray) -> Known:
        covariance = J @ C @ J.T
        before = np.einsum("ij,j,ij->i", J, prior, J)
        sure = np.diag(covariance) < (UNSURE / WIDE) ** 2 * before
        unseen = np.linalg.norm(J @ hidden, axis=1)
        sure &= unseen <= UNSEEN * np.linalg.norm(J * scale, axis=1)
        return Known(values, covariance, sure)

    J = np.vstack([dpi, dphi])
    return EstimatedParameters(
        pi=known(pi, dpi),
        phi=known(phi, dphi),
        base=known(beta, np.eye(beta.size)),
        covariance=J @ C @ J.T,
    )
