"""The total mass from every product form of Eq. 32.

Of `pi`, all but the first (one for each `iota`) are made of `M` and `phi` alone:

    pi_i = M g_i(phi),   g_i = c_i + C_i phi + sum_ab Q_i,ab phi_a phi_b

so each is a form of Eq. 32, with its own variance. They are combined by their
covariance: generalised least squares on `pi - M g(phi) = 0`.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from orbident.estimation.triangular import LinearFit
from orbident.regressors.minimal_sets import MinimalSets

# Directions of the combined covariance below this fraction of the largest are
# rounding: they would be trusted without limit.
FLOOR = 1e-12
# The weights depend on M only a little: two rounds settle M, the third its deviation.
ROUNDS = 3


class ProductForms(NamedTuple):
    """`pi_i = M g_i(phi)` for those `pi` that hold no inertia."""

    g: Float[np.ndarray, " pi"]
    """For every `pi`: the part of it over `M` that `phi` makes up."""
    dg: Float[np.ndarray, "pi phi"]


class Mass(NamedTuple):
    """The total mass and how it came about."""

    value: float
    """kg; NaN where no form gives it."""
    std: float
    forms: Int[np.ndarray, " forms"]
    """Which `pi` gave a form."""
    values: Float[np.ndarray, " forms"]
    stds: Float[np.ndarray, " forms"]
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
    """Combine every form of Eq. 32 whose `pi` and `phi` are determined."""
    products = product_forms(sets, phi.values)
    forms = _usable(sets, products, pi.determined, phi.determined)
    g, dg = products.g[forms], products.dg[forms]
    C_pi = pi.covariance[np.ix_(forms, forms)]
    C_phi = dg @ phi.covariance @ dg.T
    nothing = np.zeros_like(products.g), np.zeros_like(phi.values)
    if forms.size == 0:
        return Mass(np.nan, np.nan, forms, g, g, *nothing)
    values = pi.values[forms] / g
    M = float(np.median(values))
    C = weights = np.zeros(0)
    for _ in range(ROUNDS):
        C = C_pi + M**2 * C_phi
        weights = _weights(C, g)
        M = float(weights @ pi.values[forms] / (weights @ g))
    scale = weights @ g
    of_pi, of_phi = nothing
    of_pi[forms] = weights / scale
    of_phi = -M * (weights @ dg) / scale
    return Mass(
        value=M,
        std=float(np.sqrt(weights @ C @ weights) / abs(scale)),
        forms=forms,
        values=values,
        stds=np.sqrt(np.diag(C)) / np.abs(g),
        of_pi=of_pi,
        of_phi=of_phi,
    )


def _usable(
    sets: MinimalSets,
    products: ProductForms,
    pi: Bool[np.ndarray, " pi"],
    phi: Bool[np.ndarray, " phi"],
) -> Int[np.ndarray, " forms"]:
    """Forms without inertia, of determined parameters, with a denominator."""
    largest = np.abs(products.g).max(initial=0.0)
    usable = pi & (np.abs(products.g) > FLOOR * largest)
    usable[: sets.iotas] = False
    undetermined = np.abs(products.dg[:, ~phi]).max(axis=1, initial=0.0)
    usable &= undetermined <= FLOOR * np.abs(products.dg).max(initial=1.0)
    return np.flatnonzero(usable)


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
