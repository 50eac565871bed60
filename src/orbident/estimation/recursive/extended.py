"""The free-flying base parameters sample by sample: an extended square-root filter.

Its unknowns are `[h_cm, v_cm, b_g, b_a | pi, phi]`, in which the conservation laws are
linear: a triangular factor holds all that the samples said, whatever `beta` was
believed to be meanwhile. What is known beforehand joins it, by Gauss and Newton, one
step a sample:

    beta = argmin |R y(beta) - z|^2 + |root (beta - beta_0)|^2,   y = [pi, phi]

A filter whose state is `beta` alone would linearise every sample about another `beta`,
and take the differences for information: from CAD values it gets lost.
"""

from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax.scipy.linalg import solve_triangular
from jaxtyping import Float, Shaped
from scipy.linalg import get_lapack_funcs

from orbident.compilation import compiled
from orbident.dynamics.inertia import inertia
from orbident.estimation.recursive.equations import Model, equations, measured
from orbident.estimation.recursive.linear_sets import LinearSets
from orbident.estimation.recursive.noise import Noise
from orbident.estimation.recursive.prior import Prior, prior_from
from orbident.estimation.recursive.sample import Sample
from orbident.estimation.recursive.transition import changed, nuisances_of, walks_of
from orbident.precision import in_float64
from orbident.regressors.minimal_sets import MinimalSets
from orbident.robot.description import Robot
from orbident.robot.parameters import PER_BODY
from orbident.spatial.arrays import AnyArray
from orbident.spatial.rotations import quaternion_matrix, rotate

WIDE = 10.0
"""The momentum is unknown to so many times what CAD values say it is."""

FASTEST = 10.0
"""m/s: no point of a robot moves faster relative to the CM."""

EXACTLY = 1e-6
"""N m s: what is left of a momentum that is zero."""

BLOCK = 12
"""Columns that LAPACK factors at once."""

_geqrf, _ormqr, _tpqrt, _tpmqrt, _trtrs = get_lapack_funcs(
    ("geqrf", "ormqr", "tpqrt", "tpmqrt", "trtrs"), dtype=np.float64
)


class State(NamedTuple):
    """What is carried from sample to sample."""

    t: float
    """Of the last sample, s; NaN before the first."""
    w: Shaped[np.ndarray, "3"]
    """The gyro's last sample."""
    R_WB: Float[np.ndarray, "3 3"]
    top: Float[np.ndarray, "n all"]
    """`[N | Y | z]`: `N x + Y y = z` tells the nuisances `x`; `N` is upper triangular,
    and what is below its diagonal does not count."""
    R: Float[np.ndarray, "y y"]
    """Upper triangular: `R y = z` tells `y = [pi, phi]`."""
    z: Float[np.ndarray, "y 1"]
    prior: Prior
    beta: Float[np.ndarray, " beta"]
    """The estimate `[M, sigma, iota]`."""
    root: Float[np.ndarray, "beta beta"]
    """Upper triangular, `root^T root` the inverse of its covariance."""
    nuisances: Float[np.ndarray, " n"]
    """`[h_cm, v_cm, b_g, b_a]`, the first two in the axes that `x_WB` turns into."""

    @property
    def covariance(self) -> Float[np.ndarray, "beta beta"]:
        """Of `beta`."""
        inverse = np.linalg.inv(self.root)
        return inverse @ inverse.T


class Info(NamedTuple):
    """What one sample said about the estimate before it."""

    white: Float[np.ndarray, " e"]
    """The innovation, whitened: independent, of unit variance, while nothing changes.
    Momentum first; zero where nothing was measured."""
    nis: float
    """Its square: chi-square with `dof` degrees of freedom."""
    dof: int


@dataclass(frozen=True)
class Extended:
    """The filter of one robot."""

    model: Model
    noise: Noise
    sets: LinearSets

    @cached_property
    def treedef(self) -> Any:
        """Of `(model, noise)`: flattened once, as that takes longer than a step."""
        return jax.tree.structure((self.model, self.noise))

    @cached_property
    def leaves(self) -> tuple[AnyArray, ...]:
        """Of `(model, noise)`."""
        return tuple(jax.tree.leaves((self.model, self.noise)))

    @classmethod
    @in_float64
    def of(cls, robot: Robot, sets: MinimalSets, noise: Noise) -> "Extended":
        """The filter of a robot whose sensors have this noise."""
        noise = jax.tree.map(lambda std: jnp.asarray(std, dtype=jnp.float64), noise)
        model = Model.of(robot, sets, noise.accelerometer)
        return cls(model, noise, LinearSets.of(sets))

    @in_float64
    def start(self, prior: Prior, sample: Sample, at_rest: bool = False) -> State:
        """Nothing is known but the prior; the sample itself is not used up.

        Args:
            prior: of `beta`.
            sample: complete; sets the scale of the momentum.
            at_rest: all was at rest before the wheels spun up, so `h_cm = 0` is known
                (Eqs. 25 and 26).
        """
        h_cm, R_WB = _first(self.model, prior.beta, sample.packed)
        h, v = self.model.axes
        v_cm = np.nan_to_num(sample.v_S)[v]
        places = nuisances_of(self.model)
        x = np.zeros(sum(place.size for place in places))
        x[places[0]], x[places[1]] = np.asarray(h_cm)[h], v_cm
        state = self._fresh(np.nan, np.asarray(R_WB), prior, x)
        if at_rest:
            state.top[places[0], places[0]] = 1 / EXACTLY
            state.top[places[0], -1] = 0.0
            state.nuisances[places[0]] = 0.0
        return state

    @property
    def rows(self) -> int:
        """Of a sample's innovation."""
        return sum(axes.size for axes in self.model.axes)

    def opened(self, state: State, covariance: Float[np.ndarray, "beta beta"]) -> State:
        """The robot has changed: the estimate becomes the prior of what it is now.

        Args:
            state: before.
            covariance: of what may have changed, added to the estimate's own.
        """
        prior = prior_from(state.beta, state.covariance + covariance)
        return self._fresh(state.t, state.R_WB, prior, state.nuisances)

    def biases(self, state: State) -> dict[str, Float[np.ndarray, " k"]]:
        """Of gyro (rad/s) and accelerometer (m/s^2), base axes."""
        _, _, b_g, b_a = (state.nuisances[own] for own in nuisances_of(self.model))
        return {"gyro": b_g, "accelerometer": b_a}

    def _fresh(
        self,
        t: float,
        R_WB: Float[np.ndarray, "3 3"],
        prior: Prior,
        x: Float[np.ndarray, " n"],
    ) -> State:
        """Nothing is known but the prior, and the nuisances hardly at all."""
        h, _, _, _ = places = nuisances_of(self.model)
        noise = self.noise
        stds = (
            WIDE * max(float(np.linalg.norm(x[h])), 1.0),
            FASTEST,
            noise.gyro_bias,
            noise.accelerometer_bias,
        )
        std = np.concatenate(
            [np.full(own.size, s) for own, s in zip(places, stds, strict=True)]
        )
        y = self.sets.size
        return State(
            t=t,
            w=np.full(3, np.nan),
            R_WB=R_WB,
            top=np.hstack(
                [np.diag(1 / std), np.zeros((x.size, y)), (x / std)[:, None]]
            ),
            R=np.zeros((y, y)),
            z=np.zeros((y, 1)),
            prior=prior,
            beta=prior.beta,
            root=prior.root,
            nuisances=x,
        )

    def step(self, state: State, sample: Sample) -> tuple[State, Info]:
        """Take one sample in.

        One that is not complete, or not later than the last one, leaves the state as
        it is; so does one whose rate is the last one's to the last digit: that is how
        a gyro dies, or how a row is written twice.
        """
        e = self.rows
        again = sample.t <= state.t or np.array_equal(sample.w, state.w)
        if again or not sample.complete:
            return state, Info(np.zeros(e), 0.0, 0)
        with jax.enable_x64(True):
            linear = _linear(
                self.treedef,
                self.leaves,
                state.beta,
                state.nuisances,
                state.top,
                state.R_WB,
                np.array([state.t, sample.t]),
                sample.packed,
            )
        rows, R_WB = (np.asarray(part) for part in linear)
        y, J = self.sets.at(state.beta)
        top, rest = _eliminated(rows, walks_of(self.model), len(state.top))
        R, V, T, _ = _tpqrt(0, min(BLOCK, y.size), state.R, rest[:, :-1])
        z, white, _ = _tpmqrt(0, V, T, state.z, rest[:, -1:], trans="T")
        beta, root = _newton(state, R, z, J, y)
        n = len(top)
        told = top[:, -1] - top[:, n:-1] @ (y + J @ (beta - state.beta))
        x, _ = _trtrs(top[:, :n], told)
        after = State(sample.t, sample.w, R_WB, top, R, z, state.prior, beta, root, x)
        dof = e if np.isfinite(sample.v_S).all() else self.model.axes[0].size
        return after, Info(white[:, 0], float(white[:, 0] @ white[:, 0]), dof)


def _eliminated(
    rows: Float[np.ndarray, "rows columns"], walks: int, n: int
) -> tuple[Float[np.ndarray, "n all"], Float[np.ndarray, "e right"]]:
    """Rotate walks and nuisances out of the last rows.

    Only these columns are factored: what is left of the sample keeps its directions.
    """
    k = walks + n
    qr, tau, _, _ = _geqrf(rows[:, :k])
    right, _, _ = _ormqr("L", "T", qr, tau, rows[:, k:], BLOCK * rows.shape[1])
    top = np.hstack([qr[walks:k, walks:], right[walks:k]])
    return top, right[k:]


def _newton(
    state: State,
    R: Float[np.ndarray, "y y"],
    z: Float[np.ndarray, "y 1"],
    J: Float[np.ndarray, "y beta"],
    y: Float[np.ndarray, " y"],
) -> tuple[Float[np.ndarray, " beta"], Float[np.ndarray, "beta beta"]]:
    """One step of Gauss and Newton from `state.beta`, where `y` and `J` are."""
    prior = state.prior
    k = prior.beta.size
    rows = np.empty((y.size + k, k + 1), order="F")
    rows[: y.size, :k] = R @ J
    rows[: y.size, k:] = z - R @ (y - J @ state.beta)[:, None]
    rows[y.size :, :k] = prior.root
    rows[y.size :, k] = prior.root @ prior.beta
    qr, _, _, _ = _geqrf(rows, overwrite_a=1)
    beta, _ = _trtrs(qr[:k, :k], qr[:k, k])
    return beta, np.triu(qr[:k, :k])


@compiled
def _first(
    model: Model, beta: Float[AnyArray, " beta"], packed: Float[AnyArray, " sample"]
) -> tuple[Float[AnyArray, "3"], Float[AnyArray, "3 3"]]:
    """`R_0 (D w + D_q qd + A_rw qd_rw)` (Eq. 2), and `R_0`."""
    at = measured(model, packed)
    theta = (model.theta_of @ beta).reshape(-1, PER_BODY)
    I = inertia(model.regressors.tree, theta, at.q)
    R_WB = quaternion_matrix(at.x_WB)
    h_B = I.D @ at.w + I.D_q @ at.qd + model.wheels.A_rw @ at.qd_rw
    return rotate(R_WB, h_B), R_WB


@partial(compiled, static_argnums=0)
def _linear(
    treedef: Any,
    leaves: tuple[AnyArray, ...],
    beta: Float[AnyArray, " beta"],
    nuisances: Float[AnyArray, " n"],
    top: Float[AnyArray, "n all"],
    R_was: Float[AnyArray, "3 3"],
    times: Float[AnyArray, "2"],
    packed: Float[AnyArray, " sample"],
) -> tuple[Float[AnyArray, "rows columns"], Float[AnyArray, "3 3"]]:
    """Rows of the transition and of the sample, whitened; and `R_WB`."""
    model, noise = jax.tree.unflatten(treedef, leaves)
    at = measured(model, packed)
    moving = jnp.isfinite(at.v_S).all()
    at = at._replace(v_S=jnp.where(moving, at.v_S, 0.0))
    h = model.axes[0]
    h_cm = jnp.zeros(3).at[h].set(nuisances[: h.size])
    laws = equations(model, noise, beta, h_cm, at)
    dt = jnp.where(jnp.isnan(times[0]), 0.0, times[1] - times[0])
    moved = changed(model, noise, top, h_cm, dt * (laws.R_WB + R_was) / 2, dt)
    momentum = solve_triangular(laws.L_h, laws.momentum, lower=True)
    velocity = solve_triangular(laws.L_v, laws.velocity, lower=True)
    velocity = jnp.where(moving, velocity, 0.0)
    own = jnp.concatenate([momentum, velocity])
    own = jnp.pad(own, ((0, 0), (moved.shape[1] - own.shape[1], 0)))
    return jnp.concatenate([moved, own]), laws.R_WB
