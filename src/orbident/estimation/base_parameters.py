"""The parameters in all three descriptions, and which of them a recording determines.

They follow from separate fits of `pi` and `phi`, or from the free-flying base
parameters `beta = [M, sigma, iota]`, of which hardly anything is known beforehand.

There are more of `pi` and `phi` than base parameters that they are made of. Of all rows
of Eqs. 24 and 31 a triangular factor is left, `R y = z` of `y = [pi, phi]`, whatever
their number, and `beta` minimises `|R y(beta) - z|^2`.

The total mass follows from every product form of Eq. 32. Of `pi`, all but the first
(one for each `iota`) are made of `M` and `phi` alone:

    pi_i = M g_i(phi),   g_i = c_i + C_i phi + sum_ab Q_i,ab phi_a phi_b

so each is a form of Eq. 32, with its own variance. They are combined by their
covariance: generalised least squares on `pi - M g(phi) = 0`.
"""

import itertools
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.linalg import block_diag, null_space, qr
from scipy.optimize import least_squares

from orbident.estimation.linear_fits import Fits
from orbident.estimation.triangular import UNDETERMINED, LinearFit, check_finite
from orbident.model.kinematics import inertia_at
from orbident.model.minimal_sets import MinimalSets
from orbident.robot.description import Robot
from orbident.robot.parameters import MASS

# Directions of the combined covariance below this fraction of the largest are
# rounding: they would be trusted without limit.
FLOOR = 1e-12
# The weights depend on M only a little: two rounds settle M, the third its deviation.
ROUNDS = 3


class ProductForms(NamedTuple):
    """`pi_i = M g_i(phi)` for those `pi` that hold no inertia."""

    g: Float[np.ndarray, " pi"]
    """The part of every `pi` that `M` and `phi` make up, over `M`."""
    dg: Float[np.ndarray, "pi phi"]


class Mass(NamedTuple):
    """The total mass and how it came about."""

    value: float
    """kg; NaN where no form gives it."""
    std: float
    forms: Float[np.ndarray, "forms pi"]
    """Each form is `c pi = M c g(phi)`: the rows are `c`."""
    values: Float[np.ndarray, " forms"]
    stds: Float[np.ndarray, " forms"]
    sigmas: Float[np.ndarray, " forms"]
    """Each form less the combined mass, over the deviation of that difference."""
    spread: float
    """Weighted RMS of the forms' values about the combined one, over it."""
    of_pi: Float[np.ndarray, " pi"]
    """Derivative of the value, for propagation."""
    of_phi: Float[np.ndarray, " phi"]


def product_forms(sets: MinimalSets, phi: Float[np.ndarray, " phi"]) -> ProductForms:
    """`g_i(phi)` and its derivative, for every `pi`."""
    a, b = sets.pairs.T
    M = 1
    c, C = sets.pi_of_beta[:, 0], sets.pi_of_beta[:, M : M + phi.size]
    pairs = np.zeros((len(a), phi.size))
    order = np.arange(len(a))
    np.add.at(pairs, (order, a), phi[b])
    np.add.at(pairs, (order, b), phi[a])
    g = c + C @ phi + sets.pi_of_products @ (phi[a] * phi[b])
    return ProductForms(g, C + sets.pi_of_products @ pairs)


def mass_of(sets: MinimalSets, pi: LinearFit, phi: LinearFit) -> Mass:
    """Combine every form of Eq. 32 that the recording determines."""
    products = product_forms(sets, phi.values)
    forms = _forms(sets, products, pi, phi)
    g, dg = forms @ products.g, forms @ products.dg
    found = forms @ pi.values
    if not found.any():
        nothing = np.zeros(pi.values.size), np.zeros(phi.values.size)
        none = g[:0]
        return Mass(np.nan, np.nan, forms[:0], none, none, none, np.nan, *nothing)
    C_pi = forms @ pi.covariance @ forms.T
    C_phi = dg @ phi.covariance @ dg.T
    M = float(np.median(found / g))
    C = weights = np.zeros(0)
    for _ in range(ROUNDS):
        C = C_pi + M**2 * C_phi
        weights = _weights(C, g)
        M = float(weights @ found / (weights @ g))
    scale = weights @ g
    stds = np.sqrt(np.diag(C)) / np.abs(g)
    trust = 1 / np.maximum(stds, FLOOR * abs(M)) ** 2
    spread = np.sqrt(trust @ (found / g - M) ** 2 / trust.sum()) / abs(M)
    return Mass(
        value=M,
        std=float(np.sqrt(weights @ C @ weights) / abs(scale)),
        forms=forms,
        values=found / g,
        stds=stds,
        sigmas=_apart(found / g - M, np.diag(1 / g) - weights / scale, C, stds),
        spread=float(spread),
        of_pi=weights @ forms / scale,
        of_phi=-M * (weights @ dg) / scale,
    )


def _apart(
    differences: Float[np.ndarray, " n"],
    J: Float[np.ndarray, "n n"],
    C: Float[np.ndarray, "n n"],
    stds: Float[np.ndarray, " n"],
) -> Float[np.ndarray, " n"]:
    """Differences `J x` over their deviations, `C` being the covariance of `x`.

    NaN where a difference is zero by construction, as that of a single form is: its
    deviation is rounding beside that of the form.
    """
    variance = np.einsum("ij,jk,ik->i", J, C, J)
    sure = variance > FLOOR * stds**2
    return differences / np.sqrt(np.where(sure, variance, np.nan))


def _forms(
    sets: MinimalSets, products: ProductForms, pi: LinearFit, phi: LinearFit
) -> Float[np.ndarray, "forms pi"]:
    """All `c` without inertia for which the rows show both `c pi` and `c g(phi)`.

    Where everything is determined, they are the `pi` one by one. Where only sums are,
    as with a joint that never moved, they are the sums.
    """
    pure = np.arange(sets.iotas, pi.values.size)
    a, b = sets.pairs.T
    curved = [
        sets.pi_of_products @ (u[a] * v[b] + u[b] * v[a])
        for u, v in itertools.combinations_with_replacement(phi.hidden.T, 2)
    ]
    # c must not change along what is hidden, of pi or, to second order, of phi.
    rows = [*pi.hidden.T, *(products.dg @ phi.hidden).T, *curved]
    hidden = np.reshape([row[pure] for row in rows], (len(rows), pure.size))
    forms = np.zeros((0, pi.values.size))
    if pure.size:
        combinations = _orthogonal(hidden)
        forms = np.zeros((len(combinations), pi.values.size))
        forms[:, pure] = combinations
    g = np.abs(forms @ products.g)
    return forms[g > FLOOR * np.abs(products.g).max(initial=0.0)]


def _orthogonal(
    hidden: Float[np.ndarray, "rows n"],
) -> Float[np.ndarray, "rest n"]:
    """A sparse basis of what is orthogonal to all rows."""
    sizes = np.linalg.norm(hidden, axis=1)
    used = hidden[sizes > FLOOR * sizes.max(initial=0.0)]
    if len(used) == 0:
        return np.eye(hidden.shape[1])
    basis = null_space(
        used / np.linalg.norm(used, axis=1, keepdims=True), rcond=UNDETERMINED
    )
    # One where each is chosen, zero at the other choices: as few terms as there can be.
    *_, order = qr(basis.T, mode="r", pivoting=True)
    chosen = np.sort(order[: basis.shape[1]])
    sparse = np.linalg.solve(basis[chosen].T, basis.T)
    return np.where(np.abs(sparse) > UNDETERMINED, sparse, 0.0)


def _weights(
    C: Float[np.ndarray, "n n"], g: Float[np.ndarray, " n"]
) -> Float[np.ndarray, " n"]:
    """`C^-1 g`, with unit variances while inverting and rounding kept out."""
    std = np.sqrt(np.diag(C))
    if not std.any():
        return g / (g @ g)
    std = np.where(std > 0, std, std[std > 0].min())
    values, vectors = np.linalg.eigh(C / np.outer(std, std))
    values = np.maximum(values, FLOOR * values.max())
    return vectors @ ((vectors.T @ (g / std)) / values) / std


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
    # Nothing was measured of `phi` where its equations are empty.
    std = [fit.scatter or 1.0 for fit in (fits.pi, fits.phi)]
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
