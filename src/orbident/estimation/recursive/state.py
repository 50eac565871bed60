"""What goes into the recursive filter, what it carries, and what comes of a step."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Shaped

from orbident import _core

NOTHING_GIVEN = np.zeros(3)
"""Nothing acted from outside."""


class Sample(NamedTuple):
    """What was measured at one time, float32 or float64; NaN where nothing was.

    Without its velocity a sample counts for the momentum alone; without anything else
    it does not count.
    """

    t: float
    q: Shaped[np.ndarray, " joints"]
    qd: Shaped[np.ndarray, " joints"]
    w: Shaped[np.ndarray, "3"]
    """Gyro, base axes, rad/s."""
    x_WB: Shaped[np.ndarray, "4"]
    qd_rw: Shaped[np.ndarray, " wheels"]
    v_S: Shaped[np.ndarray, "3"]
    """Velocity of S, inertial axes, m/s."""
    w_smooth: Shaped[np.ndarray, "3"]
    """The rate with less noise, where regressors are evaluated; or the gyro again."""
    h_given: Shaped[np.ndarray, "3"] = NOTHING_GIVEN
    """Angular momentum that was given from outside so far, inertial axes, N m s."""


class State(NamedTuple):
    """What is carried from sample to sample; a constant."""

    core: _core.FilterState

    @property
    def t(self) -> float:
        """Time of the last sample, s; NaN before the first."""
        return self.core.t

    @property
    def beta(self) -> Float[np.ndarray, " beta"]:
        """The estimate `[M, sigma, iota]`."""
        return self.core.beta

    @property
    def root(self) -> Float[np.ndarray, "beta beta"]:
        """`root^T root` is the inverse of the covariance of `beta`.

        It is upper triangular in the order `[iota, M, sigma]` of its columns.
        """
        return self.core.root

    @property
    def covariance(self) -> Float[np.ndarray, "beta beta"]:
        """Covariance of `beta`."""
        inverse = np.linalg.inv(self.root)
        return inverse @ inverse.T

    @property
    def nuisances(self) -> Float[np.ndarray, " x"]:
        """`x = [h_cm, v_cm, b_g, b_a]`, the first two in the axes of `x_WB`."""
        return self.core.nuisances

    @property
    def held_in_beta(self) -> bool:
        """Whether the filter has handed over from `y = [pi, phi]` to `beta`."""
        return self.core.held_in_beta

    @property
    def top(self) -> Float[np.ndarray, "x all"]:
        """`[N | Y | z]` of `N x + Y y = z`; `N` is upper triangular.

        Once all is held in `beta`, `[N | B | z]` of `N x + B beta = z`.
        """
        return self.core.top

    @property
    def R_z(self) -> Float[np.ndarray, "y y+1"]:
        """`[R | z]` of `R y = z`, with `y = [pi, phi]`; `R` is upper triangular.

        Once all is held in `beta`, what it was when the filter handed over.
        """
        return self.core.R_z

    @property
    def R_WB(self) -> Float[np.ndarray, "3 3"]:
        """The last attitude."""
        return self.core.R_WB

    @property
    def prior(self) -> Float[np.ndarray, "beta beta+1"]:
        """`[root | z]` of what was known beforehand, `root beta = z`."""
        return self.core.prior


class Info(NamedTuple):
    """What one sample said about the estimate before it."""

    white: Float[np.ndarray, " e"]
    """The innovation, whitened: independent, of unit variance, while nothing changes.
    Momentum first; zero where nothing was measured."""
    nis: float
    """Its square: chi-square with `dof` degrees of freedom."""
    dof: int


def packed(sample: Sample) -> Float[np.ndarray, " all"]:
    """Everything but the time in one vector of float64."""
    return np.concatenate(sample[1:], dtype=np.float64)
