"""`y = [pi, phi]` of `beta`, and its derivative."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from orbident.dynamics.loops.matrices import applied
from orbident.loops import looped
from orbident.regressors.minimal_sets import MinimalSets


class LinearSets(NamedTuple):
    """What the conservation laws are linear in, as functions of `[M, sigma, iota]`."""

    pi_of_beta: Float[np.ndarray, "pi beta"]
    pi_of_products: Float[np.ndarray, "pi pairs"]
    pairs: Int[np.ndarray, "pairs 2"]
    """Which of `sigma` are multiplied."""
    sigmas: int


def linear_sets_of(sets: MinimalSets) -> LinearSets:
    """Those of a robot's minimal sets."""
    return LinearSets(
        pi_of_beta=np.ascontiguousarray(sets.pi_of_beta),
        pi_of_products=np.ascontiguousarray(sets.pi_of_products),
        pairs=np.ascontiguousarray(sets.pairs),
        sigmas=sets.base.sigmas,
    )


@looped
def linear_sets_at(sets, beta):
    """`y`, and its tangent `[J | J beta - y]`: near `beta`, `y` is `J beta` less it."""
    pis, sigmas, M, n = len(sets.pi_of_beta), sets.sigmas, beta[0], len(beta)
    y, J = np.zeros(pis + sigmas), np.zeros((pis + sigmas, n + 1))
    for k in range(sigmas):
        y[pis + k] = beta[1 + k] / M
        J[pis + k, 0] = -beta[1 + k] / M**2
        J[pis + k, 1 + k] = 1 / M
    phi = y[pis:]
    for i in range(pis):
        for k in range(n):
            y[i] += sets.pi_of_beta[i, k] * beta[k]
            J[i, k] += sets.pi_of_beta[i, k]
        # pi = pi_of_beta beta + pi_of_products (M phi_a phi_b)
        for k in range(len(sets.pairs)):
            a, b, share = sets.pairs[k, 0], sets.pairs[k, 1], sets.pi_of_products[i, k]
            y[i] += share * M * phi[a] * phi[b]
            J[i, 0] -= share * phi[a] * phi[b]
            J[i, 1 + a] += share * phi[b]
            J[i, 1 + b] += share * phi[a]
    at_beta = applied(J, beta)
    for i in range(len(y)):
        J[i, n] = at_beta[i] - y[i]
    return y, J
