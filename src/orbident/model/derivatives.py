"""How `pi` and `phi` change with the free-flying base parameters."""

import numpy as np
from jaxtyping import Float

from orbident.model.minimal_sets import MinimalSets


def derivatives_of_beta(
    sets: MinimalSets, beta: Float[np.ndarray, " beta"]
) -> tuple[Float[np.ndarray, "pi beta"], Float[np.ndarray, "phi beta"]]:
    """The derivatives of `pi` and of `phi = sigma / M` by `beta`."""
    M, sigma, iota = sets.split(beta)
    n = sigma.size
    dphi = np.hstack([-sigma[:, None] / M**2, np.eye(n) / M, np.zeros((n, iota.size))])
    a, b = sets.pairs.T
    products = np.zeros((len(sets.pairs), beta.size))
    # sigma_a sigma_b / M; += twice, for squares.
    rows = np.arange(len(sets.pairs))
    products[:, 0] = -sigma[a] * sigma[b] / M**2
    products[rows, 1 + a] += sigma[b] / M
    products[rows, 1 + b] += sigma[a] / M
    return sets.pi_of_beta + sets.pi_of_products @ products, dphi


def sets_of_beta(
    sets: MinimalSets, beta: Float[np.ndarray, " beta"]
) -> tuple[Float[np.ndarray, " pi"], Float[np.ndarray, " phi"]]:
    """`pi` and `phi` of `beta = [M, sigma, iota]`."""
    M, sigma, _ = sets.split(beta)
    a, b = sets.pairs.T
    products = sigma[a] * sigma[b] / M
    return sets.pi_of_beta @ beta + sets.pi_of_products @ products, sigma / M
