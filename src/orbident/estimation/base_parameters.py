"""The parameters in all three descriptions, and which of them a recording determines.

They follow from separate fits of `pi` and `phi`, or from the free-flying base
parameters `beta = [M, sigma, iota]`, of which hardly anything is known beforehand.

There are more of `pi` and `phi` than base parameters that they are made of. Of all rows
of Eqs. 24 and 31 a triangular factor is left, `R y = z` of `y = [pi, phi]`, whatever
their number, and `beta` minimises `|R y(beta) - z|^2`.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.linalg import block_diag
from scipy.optimize import least_squares

from orbident.estimation.linear_fits import Fits
from orbident.estimation.mass import Mass, product_forms
from orbident.estimation.triangular import UNDETERMINED, LinearFit, check_finite
from orbident.model.kinematics import inertia_at
from orbident.model.minimal_sets import MinimalSets
from orbident.robot.description import Robot
from orbident.robot.parameters import MASS

WIDE = 100.0
"""Times the robot's own scale: no robot is so far from its CAD values."""

EXACT = 1e-6
"""Differences below this part of the robot's own scale are interpolation's."""

RANK = 1e-10
"""Singular values over the largest: rounding leaves 1e-15, integration 1e-13."""

UNSURE = 1.0
"""Times the robot's own scale: a parameter less sure than this is not determined."""

PRECISION = 1e-15
"""Relative, at which MINPACK stops."""

EVALUATIONS = 200
"""The most that a fit may take: those of 20 random robots took 5 to 20."""


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


def exact_std(robot: Robot, sets: MinimalSets) -> Float[np.ndarray, " beta"]:
    """What base parameters of recordings without noise may differ by."""
    return EXACT / WIDE * prior_std(robot, sets)


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


def parameters_of_fits(
    sets: MinimalSets, fits: Fits, mass: Mass
) -> EstimatedParameters:
    """Combine separate fits of `pi` and `phi`, and the mass that follows from both."""
    pi, phi = (
        Known(fit.values, fit.covariance, fit.determined) for fit in (fits.pi, fits.phi)
    )
    base = _base(sets, fits.pi, fits.phi, mass)
    both = np.asarray(block_diag(pi.covariance, phi.covariance))
    return EstimatedParameters(pi, phi, base, both)


def _base(
    sets: MinimalSets,
    pi: LinearFit,
    phi: LinearFit,
    mass: Mass,
) -> Known:
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
    needs_unknown = unseen > UNDETERMINED * np.abs(dg).max(initial=0.0)
    iotas = pi.determined[own] & ~needs_unknown
    return Known(
        values=values,
        covariance=J @ C @ J.T,
        determined=np.concatenate([[True], phi.determined, iotas]),
    )


def parameters_of_beta(
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
        sure &= unseen <= UNDETERMINED * np.linalg.norm(J * scale, axis=1)
        return Known(values, covariance, sure)

    J = np.vstack([dpi, dphi])
    return EstimatedParameters(
        pi=known(pi, dpi),
        phi=known(phi, dphi),
        base=known(beta, np.eye(beta.size)),
        covariance=J @ C @ J.T,
    )


def beta_of_fits(robot: Robot, sets: MinimalSets, fits: Fits) -> BetaEstimate:
    """Nonlinear least squares from the nominal values, as if all noise were white."""
    std = [fit.scatter for fit in (fits.pi, fits.phi)]
    R = block_diag(fits.pi.factor / std[0], fits.phi.factor / std[1])
    z = np.concatenate([fits.pi.target / std[0], fits.phi.target / std[1]])
    nominal, wide = sets.beta(robot.theta), prior_std(robot, sets)
    return nonlinear_fit(sets, nominal, wide, np.asarray(R), z, nominal)


def nonlinear_fit(
    sets: MinimalSets,
    nominal: Float[np.ndarray, " beta"],
    wide: Float[np.ndarray, " beta"],
    R: Float[np.ndarray, "y y"],
    z: Float[np.ndarray, " y"],
    start: Float[np.ndarray, " beta"],
) -> BetaEstimate:
    """`beta` of `R y(beta) = z` near a start; what this does not tell stays nominal.

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
        (start - nominal) / wide,
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
