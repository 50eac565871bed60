"""`y = [pi, phi]` of `beta`, and its derivative; columns are stored as rows."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from orbident.dynamics.loops.matrices import add_scaled
from orbident.loops import looped
from orbident.regressors.minimal_sets import MinimalSets


class LinearSets(NamedTuple):
    """What the conservation laws are linear in, as functions of `[M, sigma, iota]`."""

    pi_of_beta: Float[np.ndarray, "beta pi"]
    pi_of_products: Float[np.ndarray, "pairs pi"]
    pairs: Int[np.ndarray, "pairs 2"]
    """Which of `sigma` are multiplied."""
    sigmas: int


def linear_sets_of(sets: MinimalSets) -> LinearSets:
    """Those of a robot's minimal sets."""
    return LinearSets(
        pi_of_beta=np.ascontiguousarray(sets.pi_of_beta.T),
        pi_of_products=np.ascontiguousarray(sets.pi_of_products.T),
        pairs=np.ascontiguousarray(sets.pairs),
        sigmas=sets.base.sigmas,
    )


@looped
def linear_sets_at(sets, beta):
    """`y`, and its tangent `[J | J beta - y]`: near `beta`, `y` is `J beta` less it."""
    n, pis = sets.pi_of_beta.shape
    M, phi = beta[0], beta[1 : 1 + sets.sigmas] / beta[0]
    y, tangent = np.zeros(pis + len(phi)), np.zeros((n + 1, pis + len(phi)))
    pi, J = y[:pis], tangent[:, :pis]
    # pi = pi_of_beta beta + pi_of_products (M phi_a phi_b)
    for k in range(n):
        add_scaled(beta[k], sets.pi_of_beta[k], pi)
        add_scaled(1.0, sets.pi_of_beta[k], J[k])
    for k in range(len(sets.pairs)):
        a, b, shares = sets.pairs[k, 0], sets.pairs[k, 1], sets.pi_of_products[k]
        add_scaled(M * phi[a] * phi[b], shares, pi)
        add_scaled(-phi[a] * phi[b], shares, J[0])
        add_scaled(phi[b], shares, J[1 + a])
        add_scaled(phi[a], shares, J[1 + b])
    for k in range(len(phi)):
        y[pis + k] = phi[k]
        tangent[0, pis + k] = -phi[k] / M
        tangent[1 + k, pis + k] = 1.0 / M
    for k in range(n):
        add_scaled(beta[k], tangent[k], tangent[n])
    add_scaled(-1.0, y, tangent[n])
    return y, tangent
