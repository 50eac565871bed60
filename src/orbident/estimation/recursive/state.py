"""What the extended filter carries from sample to sample, in one vector.

Wrapping ten arrays for a compiled step, and ten for what it gives back, would take as
long as a third of the step.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.estimation.recursive.prior import Prior
from orbident.loops import looped


class Sizes(NamedTuple):
    """How many unknowns there are."""

    x: int
    """Nuisances."""
    y: int
    """`[pi, phi]`."""
    beta: int


class Parts(NamedTuple):
    """The parts of a state; views."""

    t: Float[np.ndarray, "1"]
    """Of the last sample, s; NaN before the first."""
    w: Float[np.ndarray, "3"]
    """The gyro's last sample."""
    R_WB: Float[np.ndarray, "1 3 3"]
    top: Float[np.ndarray, "x all"]
    """`[N | Y | z]`: `N x + Y y = z` tells the nuisances `x`; `N` is upper
    triangular."""
    R_z: Float[np.ndarray, "y y+1"]
    """`[R | z]`: `R y = z` tells `y = [pi, phi]`; `R` is upper triangular."""
    beta: Float[np.ndarray, " beta"]
    """The estimate `[M, sigma, iota]`."""
    root: Float[np.ndarray, "beta beta"]
    """Upper triangular, `root^T root` the inverse of its covariance."""
    nuisances: Float[np.ndarray, " x"]
    """`[h_cm, v_cm, b_g, b_a]`, the first two in the axes that `x_WB` turns into."""
    prior: Prior


class State(NamedTuple):
    """What is carried from sample to sample; not to be written to."""

    sizes: Sizes
    packed: Float[np.ndarray, " all"]

    @property
    def parts(self) -> Parts:
        """What it consists of."""
        return parts_of(self.sizes, self.packed)

    @property
    def t(self) -> float:
        """Of the last sample, s; NaN before the first."""
        return float(self.packed[0])

    @property
    def beta(self) -> Float[np.ndarray, " beta"]:
        """The estimate `[M, sigma, iota]`."""
        return self.parts.beta

    @property
    def covariance(self) -> Float[np.ndarray, "beta beta"]:
        """Of `beta`."""
        inverse = np.linalg.inv(self.parts.root)
        return inverse @ inverse.T


def state_of(parts: Parts) -> State:
    """The parts, packed."""
    sizes = Sizes(len(parts.nuisances), len(parts.R_z), len(parts.beta))
    every = (*parts[:-1], *parts.prior)
    return State(sizes, np.concatenate([np.ravel(part) for part in every]))


@looped
def parts_of(sizes, packed):
    """The parts of a state, where they are in `State.packed`."""
    x, y, beta = sizes
    t, w, rest = packed[:1], packed[1:4], packed[4:]
    R_WB, rest = _matrix(rest, 3, 3)
    top, rest = _matrix(rest, x, x + y + 1)
    R_z, rest = _matrix(rest, y, y + 1)
    estimate, rest = rest[:beta], rest[beta:]
    root, rest = _matrix(rest, beta, beta)
    nuisances, rest = rest[:x], rest[x:]
    prior, rest = rest[:beta], rest[beta:]
    prior_root, rest = _matrix(rest, beta, beta)
    R_WB = R_WB.reshape((1, 3, 3))
    prior = Prior(prior, prior_root)
    return Parts(t, w, R_WB, top, R_z, estimate, root, nuisances, prior)


@looped
def _matrix(packed, rows, columns):
    """The first one, and what comes after it."""
    size = rows * columns
    return packed[:size].reshape((rows, columns)), packed[size:]
