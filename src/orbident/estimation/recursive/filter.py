"""The free-flying base parameters sample by sample: an extended square-root filter.

Its unknowns are `[h_cm, v_cm, p, b_g, b_a, drives | pi, phi]`, in which the
conservation laws and the momenta `p` of joints with measured torques are linear, and
`beta` follows from them and from what is known beforehand by one Gauss-Newton step a
sample. The equations stand in the core's `information_filter.hpp`.

Before any sample, CAD values are believed to be uncertain by 30 %.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int, Shaped
from scipy.linalg import solve_triangular

from orbident import _core
from orbident.errors import InputError
from orbident.estimation.recursive.filter_input import Noise
from orbident.estimation.triangular import check_finite
from orbident.model.core_robot import core_robot, rotor_deviations
from orbident.model.minimal_sets import MinimalSets, minimal_sets
from orbident.model.reconstruction import root_of
from orbident.robot.description import Robot
from orbident.robot.parameters import INERTIA, MASS, PER_BODY
from orbident.threads import processors

UNCERTAINTY = 0.3
"""The relative uncertainty of CAD values."""


class GaussianPrior(NamedTuple):
    """Gaussian; `root^T root` is the inverse of the covariance."""

    beta: Float[np.ndarray, " beta"]
    root: Float[np.ndarray, "beta beta"]
    """Upper triangular."""


def prior_from(
    beta: Float[np.ndarray, " beta"], covariance: Float[np.ndarray, "beta beta"]
) -> GaussianPrior:
    """The prior with this mean and covariance.

    Raises:
        InputError: the covariance is not positive definite.
    """
    L = factor_of(covariance)
    inverse = solve_triangular(L, np.eye(len(L)), lower=True)
    root = np.linalg.qr(inverse, mode="r")
    return GaussianPrior(beta, np.ascontiguousarray(root))


def factor_of(
    covariance: Float[np.ndarray, "beta beta"],
) -> Float[np.ndarray, "beta beta"]:
    """Lower triangular `L` of `L L^T`.

    Raises:
        InputError: the covariance is not positive definite.
    """
    std = np.sqrt(np.diag(covariance))
    try:
        # With unit variances: kg and kg m^2 differ by orders of magnitude.
        L = np.linalg.cholesky(covariance / np.outer(std, std))
    except np.linalg.LinAlgError:
        raise InputError(
            "the covariance of beta is not positive definite; give that of an "
            "estimate that determines every parameter"
        ) from None
    return np.ascontiguousarray(std[:, None] * L)


def cad_prior(robot: Robot, uncertainty: float = UNCERTAINTY) -> GaussianPrior:
    """The nominal values, wrong by so much.

    Of a body of mass `m` and size `l` the standard deviations are `uncertainty` times
    `m`, `m l` (first moments) and `m l^2` (inertias), each parameter for itself.

    Args:
        robot: with its nominal inertia.
        uncertainty: relative.
    """
    covariance = cad_covariance(robot, uncertainty)
    return prior_from(minimal_sets(robot).beta(robot.theta), covariance)


def cad_covariance(robot: Robot, uncertainty: float) -> Float[np.ndarray, "beta beta"]:
    """The covariance of `beta`, as `cad_prior` has it."""
    m = robot.theta[:, MASS]
    trace = robot.theta[:, INERTIA][:, [0, 2, 5]].sum(axis=1)
    # A body's trace is twice its second moment, m l^2.
    size = np.sqrt(trace / 2 / np.where(m > 0, m, 1.0))[:, None]
    powers = np.array([0] + [1] * 3 + [2] * (PER_BODY - 4))
    T = minimal_sets(robot).base.T
    of_bodies = T * (uncertainty * m[:, None] * size**powers).ravel()
    of_rotors = T @ rotor_deviations(robot)
    return of_bodies @ of_bodies.T + of_rotors @ of_rotors.T


NO_MOMENTUM = np.zeros(3)
"""Nothing acted from outside."""

NO_IMPULSE = np.zeros(0)
"""No torque is measured."""


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
    h_given: Shaped[np.ndarray, "3"] = NO_MOMENTUM
    """Angular momentum that was given from outside so far, inertial axes, N m s."""
    impulse: Shaped[np.ndarray, " driven"] = NO_IMPULSE
    """Integrals of the torques of driven joints so far, N m s."""


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
        """`x = [h_cm, v_cm, p, b_g, b_a, drives]`, the first two in the axes of `x_WB`.

        `p` are the momenta of driven joints; of each of them `drives` has the armature,
        viscous and Coulomb friction, the offset, and the sensor's scale.
        """
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
    """The square of the innovation: chi-square with `dof` degrees of freedom."""
    dof: int


def packed(sample: Sample) -> Float[np.ndarray, " all"]:
    """Everything but the time in one vector of float64."""
    return np.concatenate(sample[1:], dtype=np.float64)


ROUNDING = 1e-10
"""Entries of the minimal sets' maps, over the largest one, that are zero but for
rounding: true entries are lengths and their products over the robot's size."""


@dataclass(frozen=True)
class Extended:
    """The filter of one robot."""

    sets: MinimalSets
    noise: Noise
    core: _core.Filter

    @classmethod
    def of(cls, robot: Robot, noise: Noise) -> "Extended":
        """The filter of a robot whose sensors have this noise."""
        sets = minimal_sets(robot)
        of_products = sparse(sets.pi_of_products.toarray())
        order = by_last_row(of_products)
        apart = ("declared", "driven")
        known = {name: x for name, x in noise._asdict().items() if name not in apart}
        core = _core.Filter(
            robot=core_robot(robot),
            sets=sets.regressors.core,
            theta_of=sparse(sets.base.theta_of),
            pi_of_beta=sparse(sets.pi_of_beta),
            pi_of_products=np.ascontiguousarray(of_products[:, order]),
            pairs=sets.pairs[order].astype(float).ravel(),
            sigmas=sets.base.sigmas,
            momentum_axes=np.array(sets.regressors.momentum_axes, dtype=float),
            velocity_axes=np.array(sets.regressors.velocity_axes, dtype=float),
            noise=_core.SensorNoise(**known),
            driven=noise.driven.table,
            longest=noise.driven.longest,
        )
        return cls(sets, noise, core)

    @property
    def rows(self) -> int:
        """Size of a sample's innovation."""
        own = self.sets.regressors
        return len(own.momentum_axes) + len(own.velocity_axes)

    def start(
        self,
        prior: GaussianPrior,
        sample: Sample,
        h_cm: Float[np.ndarray, "3"] | None = None,
    ) -> State:
        """Nothing is known but the prior; the sample itself is not used up.

        Args:
            prior: of `beta`.
            sample: complete; sets the scale of the momentum.
            h_cm: the momentum where it is known (Eqs. 25 and 26), inertial axes, N m s.
        """
        return self.begun(prior, packed(sample), h_cm)

    def begun(
        self,
        prior: GaussianPrior,
        sample: Float[np.ndarray, " all"],
        h_cm: Float[np.ndarray, "3"] | None,
    ) -> State:
        """The same of a packed sample."""
        known = None if h_cm is None else np.asarray(h_cm, dtype=float)
        return State(self.core.start(prior.beta, prior.root, sample, known))

    def step(self, state: State, sample: Sample) -> tuple[State, Info]:
        """Take one sample in.

        One that is not complete, or not later than the last one, leaves the state as
        it is; so does one whose rate is the last one's to the last digit: that is how
        a gyro dies, or how a row is written twice.
        """
        after, white, nis, dof = self.core.step(state.core, sample.t, packed(sample))
        return State(after), Info(white, nis, dof)

    def opened(self, state: State, covariance: Float[np.ndarray, "beta beta"]) -> State:
        """The robot has changed: the estimate becomes the prior of what it is now.

        Args:
            state: before.
            covariance: of what may have changed, added to the estimate's own.

        Raises:
            InputError: the covariance is not positive definite.
        """
        return State(self.core.opened(state.core, factor_of(covariance)))

    def gathered(
        self,
        state: State,
        t: Float[np.ndarray, " n"],
        samples: Float[np.ndarray, "n all"],
    ) -> tuple[State, float, int]:
        """Take many samples in, all linearised about the estimate, which stays.

        Args:
            state: before.
            t: of the samples, s.
            samples: packed, one a row.

        Returns:
            The state after the last one, with the estimate and the nuisances of before;
            the squared residuals of the equations, which are of unit variance; and how
            many equations these are.
        """
        after, squares, rows = self.core.gathered(state.core, t, samples, processors())
        return State(after), squares, rows

    def biases(
        self,
        state: State,
        beta: Float[np.ndarray, " beta"],
        covariance: Float[np.ndarray, "beta beta"],
    ) -> dict[str, dict[str, float]]:
        """Those of gyro (rad/s) and accelerometer (m/s^2), in base axes.

        Args:
            state: what it says of its nuisances counts.
            beta: the estimate,
            covariance: and its own.

        Returns:
            By name, as `gyro.x`: `value` and `std`.

        Raises:
            InputError: the equations overflow.
        """
        n, top = len(state.top), state.top
        check_finite(top, covariance)
        N, Y, z = top[:, :n], top[:, n:-1], top[:, -1]
        y, J = beta, Y
        if not state.held_in_beta:
            y = np.concatenate(self.sets.pi_and_phi(beta))
            J = Y @ np.vstack(self.sets.derivatives(beta))
        x = solve_triangular(N, z - Y @ y)
        spread = np.hstack([np.eye(n), J @ root_of(covariance)])
        std = np.linalg.norm(solve_triangular(N, spread), axis=1)
        own = self.sets.regressors
        h, v = len(own.momentum_axes), len(own.velocity_axes)
        names = [f"gyro.{'xyz'[axis]}" for axis in own.momentum_axes]
        names += [f"accelerometer.{'xyz'[axis]}" for axis in own.velocity_axes]
        first = h + v + len(self.noise.driven.table)
        return {
            name: {"value": float(x[k]), "std": float(std[k])}
            for name, k in zip(names, range(first, n), strict=False)
        }


def sparse(A: Float[np.ndarray, "m n"]) -> Float[np.ndarray, "m n"]:
    """Without what is zero but for rounding."""
    size = np.abs(A)
    return np.where(size > ROUNDING * size.max(initial=0.0), A, 0.0)


def by_last_row(A: Float[np.ndarray, "m n"]) -> Int[np.ndarray, " used"]:
    """The columns that are not zero, in the order of their last entries."""
    used = np.flatnonzero(A.any(axis=0))
    last = len(A) - 1 - (A[::-1, used] != 0).argmax(axis=0)
    return used[np.argsort(last, kind="stable")]
