"""The total mass from every product form of Eq. 32.

Of `pi`, all but the first (one for each `iota`) are made of `M` and `phi` alone:

    pi_i = M g_i(phi),   g_i = c_i + C_i phi + sum_ab Q_i,ab phi_a phi_b

so each is a form of Eq. 32, with its own variance. They are combined by their
covariance: generalised least squares on `pi - M g(phi) = 0`.
"""

import itertools
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.linalg import null_space, qr

from orbident.estimation.triangular import UNDETERMINED, LinearFit
from orbident.model.minimal_sets import MinimalSets

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
