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
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.dynamics.loops.bodies import room
from orbident.dynamics.loops.matrices import add_scaled, applied, finite, left
from orbident.dynamics.loops.vectors import quaternion_matrix
from orbident.estimation.recursive.equations import (
    Model,
    complete,
    equations,
    inertia_at,
    measured,
    model_of,
    momentum_of_wheels,
)
from orbident.estimation.recursive.folding import fold, solved
from orbident.estimation.recursive.linear_sets import (
    LinearSets,
    linear_sets_at,
    linear_sets_of,
)
from orbident.estimation.recursive.noise import Noise
from orbident.estimation.recursive.prior import Prior, prior_from
from orbident.estimation.recursive.sample import Sample
from orbident.estimation.recursive.transition import moved
from orbident.loops import looped
from orbident.regressors.minimal_sets import MinimalSets
from orbident.robot.description import Robot

WIDE = 10.0
"""The momentum is unknown to so many times what CAD values say it is."""

FASTEST = 10.0
"""m/s: no point of a robot moves faster relative to the CM."""

EXACTLY = 1e-6
"""N m s: what is left of a momentum that is zero."""


class State(NamedTuple):
    """What is carried from sample to sample."""

    t: float
    """Of the last sample, s; NaN before the first."""
    w: Float[np.ndarray, "3"]
    """The gyro's last sample."""
    R_WB: Float[np.ndarray, "1 3 3"]
    top: Float[np.ndarray, "n all"]
    """`[N | Y | z]`: `N x + Y y = z` tells the nuisances `x`; `N` is upper
    triangular."""
    R_z: Float[np.ndarray, "y y+1"]
    """`[R | z]`: `R y = z` tells `y = [pi, phi]`; `R` is upper triangular."""
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

    @classmethod
    def of(cls, robot: Robot, sets: MinimalSets, noise: Noise) -> "Extended":
        """The filter of a robot whose sensors have this noise."""
        # Of one type: whole numbers would be compiled for again.
        stds = (float(std) for std in noise[:-1])
        noise = Noise(*stds, accelerometer=noise.accelerometer)
        return cls(model_of(robot, sets), noise, linear_sets_of(sets))

    def start(self, prior: Prior, sample: Sample, at_rest: bool = False) -> State:
        """Nothing is known but the prior; the sample itself is not used up.

        Args:
            prior: of `beta`.
            sample: complete; sets the scale of the momentum.
            at_rest: all was at rest before the wheels spun up, so `h_cm = 0` is known
                (Eqs. 25 and 26).
        """
        h_cm, R_WB = _momentum(self.model, prior.beta, sample.packed)
        places = self._nuisances
        x = np.zeros(sum(place.size for place in places))
        x[places[0]] = h_cm[self.model.turning]
        x[places[1]] = np.nan_to_num(sample.v_S)[self.model.moving]
        state = self._fresh(np.nan, R_WB, prior, x)
        if at_rest:
            state.top[places[0], places[0]] = 1 / EXACTLY
            state.top[places[0], -1] = 0.0
            state.nuisances[places[0]] = 0.0
        return state

    @property
    def rows(self) -> int:
        """Of a sample's innovation."""
        return self.model.turning.size + self.model.moving.size

    def opened(self, state: State, covariance: Float[np.ndarray, "beta beta"]) -> State:
        """The robot has changed: the estimate becomes the prior of what it is now.

        Args:
            state: before.
            covariance: of what may have changed, added to the estimate's own.
        """
        prior = prior_from(state.beta, state.covariance + covariance)
        return self._fresh(state.t, state.R_WB, prior, state.nuisances)

    @property
    def _nuisances(self) -> list[np.ndarray]:
        """Where `h_cm`, `v_cm`, `b_g` and `b_a` are among the nuisances."""
        h, v = self.model.turning.size, self.model.moving.size
        sizes = [h, v, h, v if self.noise.accelerometer else 0]
        return np.split(np.arange(sum(sizes)), np.cumsum(sizes)[:-1])

    def biases(self, state: State) -> dict[str, Float[np.ndarray, " k"]]:
        """Of gyro (rad/s) and accelerometer (m/s^2), base axes."""
        _, _, b_g, b_a = (state.nuisances[own] for own in self._nuisances)
        return {"gyro": b_g, "accelerometer": b_a}

    def _fresh(
        self,
        t: float,
        R_WB: Float[np.ndarray, "1 3 3"],
        prior: Prior,
        x: Float[np.ndarray, " n"],
    ) -> State:
        """Nothing is known but the prior, and the nuisances hardly at all."""
        h, _, _, _ = places = self._nuisances
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
        y = len(self.sets.pi_of_beta) + self.sets.sigmas
        return State(
            t=t,
            w=np.full(3, np.nan),
            R_WB=R_WB,
            top=np.hstack(
                [np.diag(1 / std), np.zeros((x.size, y)), (x / std)[:, None]]
            ),
            R_z=np.zeros((y, y + 1)),
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
        return _step(self.model, self.noise, self.sets, state, sample.t, sample.packed)


@looped
def _step(model, noise, sets, state, t, packed):
    """`Extended.step`, compiled."""
    at = measured(model, packed)
    n_h, n_v, n = len(model.turning), len(model.moving), len(state.top)
    if t <= state.t or not complete(at) or _same(at.w, state.w):
        return state, Info(np.zeros(n_h + n_v), 0.0, 0)

    x = state.nuisances
    h_cm = (0.0, 0.0, x[0]) if n_h == 1 else (x[0], x[1], x[2])
    R_WB = quaternion_matrix(at.x_WB[0], at.x_WB[1], at.x_WB[2], at.x_WB[3])
    dt = 0.0 if np.isnan(state.t) else t - state.t
    top = moved(model, noise, state, R_WB, h_cm, dt)
    rows = equations(model, noise, state.beta, h_cm, at, R_WB)
    moving = finite(at.v_S)
    fold(top, rows, 0, n)
    R_z = state.R_z.copy()
    fold(R_z, rows, n, len(R_z))

    beta, root, y = _newton(sets, state, R_z)
    white, nis = np.empty(n_h + n_v), 0.0
    for i in range(len(white)):
        white[i] = rows[i, -1]
        nis += white[i] ** 2
    x = _nuisances(top, y)
    after = State(t, at.w.copy(), R_WB, top, R_z, state.prior, beta, root, x)
    return after, Info(white, nis, n_h + n_v if moving else n_h)


@looped
def _same(a, b):
    equal = True
    for i in range(len(a)):
        equal = equal and a[i] == b[i]
    return equal


@looped
def _newton(sets, state, R_z):
    """`beta` after a step of Gauss and Newton from the last, its root, and `y`."""
    prior, k, n = state.prior, len(state.beta), len(R_z)
    _, tangent = linear_sets_at(sets, state.beta)
    rows, root = np.zeros((n, k + 1)), np.zeros((k, k + 1))
    for i in range(n):
        rows[i, k] = R_z[i, n]
        for j in range(i, n):
            add_scaled(R_z[i, j], tangent[j], rows[i])
    for i in range(k):
        for j in range(i, k):
            root[i, j] = prior.root[i, j]
            root[i, k] += prior.root[i, j] * prior.beta[j]
    fold(root, rows, 0, k)
    beta = solved(root)
    y = applied(tangent, beta)
    for i in range(n):
        y[i] -= tangent[i, k]
    return beta, left(root, k), y


@looped
def _nuisances(top, y):
    """`x` of `N x + Y y = z`."""
    n = len(top)
    N_z = np.empty((n, n + 1))
    for i in range(n):
        for j in range(n):
            N_z[i, j] = top[i, j]
        N_z[i, n] = top[i, -1]
        for j in range(len(y)):
            N_z[i, n] -= top[i, n + j] * y[j]
    return solved(N_z)


@looped
def _momentum(model, beta, packed):
    """`R_0 (D w + D_q qd + A_rw qd_rw)` (Eq. 2), and `R_0`."""
    at, joints = measured(model, packed), len(model.columns.joints.parent)
    bodies, H = room(joints + 1), np.zeros((6 + joints, 6 + joints))
    inertia_at(model, beta, at.q, bodies, H)
    h_B = np.array(momentum_of_wheels(model, at))
    for i in range(3):
        for j in range(3):
            h_B[i] += H[3 + max(i, j), 3 + min(i, j)] * at.w[j]
        for k in range(joints):
            h_B[i] += H[6 + k, 3 + i] * at.qd[k]
    R_WB = quaternion_matrix(at.x_WB[0], at.x_WB[1], at.x_WB[2], at.x_WB[3])
    return applied(R_WB[0], h_B), R_WB
