"""What a method found, in all three descriptions, and what it left undetermined.

The free-flying base parameters from `(pi, phi, M)`, with their covariance.

What is known of `beta` before anything is measured: hardly anything.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.linalg import block_diag

from orbident.estimation.linear_fits import Fits
from orbident.estimation.mass import Mass, product_forms
from orbident.estimation.triangular import UNSEEN, LinearFit
from orbident.model.inertia import inertia_at
from orbident.model.minimal_sets import MinimalSets
from orbident.robot.description import Robot
from orbident.robot.parameters import MASS


class BaseEstimate(NamedTuple):
    """`beta = [M, sigma, iota]`; an entry counts where it is `determined`."""

    values: Float[np.ndarray, " beta"]
    covariance: Float[np.ndarray, "beta beta"]
    determined: Bool[np.ndarray, " beta"]


def base_parameters(
    sets: MinimalSets,
    pi: LinearFit,
    phi: LinearFit,
    mass: Mass,
) -> BaseEstimate:
    """`M`, `sigma = M phi`, `iota_i = pi_i - M g_i(phi)`.

    Args:
        sets: the robot's minimal sets.
        pi: estimate of `pi`.
        phi: estimate of `phi`.
        mass: estimate of `M`, with its derivatives.
    """
    g, dg = product_forms(sets, phi.values)
    own = slice(0, sets.iotas)
    M = mass.value
    values = np.concatenate([[M], M * phi.values, pi.values[own] - M * g[own]])
    # Rows: derivative of M, of sigma, of iota, over [pi, phi].
    dM = np.concatenate([mass.of_pi, mass.of_phi])
    dsigma = np.outer(phi.values, dM)
    dsigma[:, pi.values.size :] += M * np.eye(phi.values.size)
    diota = -np.outer(g[own], dM)
    diota[:, own] += np.eye(sets.iotas)
    diota[:, pi.values.size :] -= M * dg[own]
    J = np.vstack([dM, dsigma, diota])
    C = block_diag(pi.covariance, phi.covariance)
    unseen = np.abs(dg[own] @ phi.hidden).max(axis=1, initial=0.0)
    needs_unknown = unseen > UNSEEN * np.abs(dg).max(initial=0.0)
    iotas = pi.determined[own] & ~needs_unknown
    return BaseEstimate(
        values=values,
        covariance=J @ C @ J.T,
        determined=np.concatenate([[True], phi.determined, iotas]),
    )


WIDE = 100.0
"""Times the robot's own scale: no robot is so far from its CAD values."""


def prior_std(robot: Robot, sets: MinimalSets) -> Float[np.ndarray, " beta"]:
    """Standard deviations about the nominal values of `[M, sigma, iota]`.

    `M`, `M L` and `M L^2` with `L` the nominal radius of gyration, a hundred times
    each: what the recording tells, it tells far better, and what it does not tell
    keeps the equations solvable and is recognised by it.
    """
    D = inertia_at(robot, np.zeros(len(robot.joints))).D
    M = float(robot.theta[:, MASS].sum())
    # Of CAD values that no body can have, D may be anything.
    L = float(np.sqrt(np.abs(np.diag(D)).sum() / M))
    size = np.repeat([1.0, L, L**2], [1, sets.base.sigmas, sets.iotas])
    return WIDE * M * size


EXACT = 1e-6
"""Differences below this part of the robot's own scale are interpolation's."""


def exact_std(robot: Robot, sets: MinimalSets) -> Float[np.ndarray, " beta"]:
    """What base parameters of recordings without noise may differ by."""
    return EXACT / WIDE * prior_std(robot, sets)


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
    pi, phi = sets.pi_and_phi(beta)
    dpi, dphi = sets.derivatives(beta)

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
