"""The free-flying base parameters from `(pi, phi, M)`, with their covariance."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.linalg import block_diag

from orbident.estimation.mass import Mass, product_forms
from orbident.estimation.triangular import UNSEEN, LinearFit
from orbident.model.minimal_sets import MinimalSets


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
