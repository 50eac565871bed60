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
from functools import cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.dynamics.loops.bodies import room
from orbident.dynamics.loops.matrices import add_scaled, applied, assign, dot, finite
from orbident.dynamics.loops.vectors import put, quaternion_matrix, row
from orbident.estimation.recursive.equations import (
    Model,
    complete,
    equations,
    inertia_at,
    measured,
    model_in,
    model_of,
    momentum_of_wheels,
    plain,
)
from orbident.estimation.recursive.folding import fold, fold_columns, solved
from orbident.estimation.recursive.linear_sets import (
    LinearSets,
    linear_sets_at,
    linear_sets_of,
)
from orbident.estimation.recursive.noise import Noise
from orbident.estimation.recursive.prior import Prior, prior_from
from orbident.estimation.recursive.sample import Sample
from orbident.estimation.recursive.state import Parts, State, parts_of, state_of
from orbident.estimation.recursive.transition import move_on
from orbident.loops import looped
from orbident.regressors.minimal_sets import MinimalSets
from orbident.robot.description import Robot

WIDE = 10.0
"""The momentum is unknown to so many times what CAD values say it is."""

FASTEST = 10.0
"""m/s: no point of a robot moves faster relative to the CM."""

EXACTLY = 1e-6
"""N m s: what is left of a momentum that is zero."""


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
        parts = self._fresh(np.nan, R_WB, prior, x)
        if at_rest:
            parts.top[places[0], places[0]] = 1 / EXACTLY
            parts.top[places[0], -1] = 0.0
            parts.nuisances[places[0]] = 0.0
        return state_of(parts)

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
        parts = state.parts
        return state_of(self._fresh(state.t, parts.R_WB, prior, parts.nuisances))

    @property
    def _nuisances(self) -> list[np.ndarray]:
        """Where `h_cm`, `v_cm`, `b_g` and `b_a` are among the nuisances."""
        h, v = self.model.turning.size, self.model.moving.size
        sizes = [h, v, h, v if self.noise.accelerometer else 0]
        return np.split(np.arange(sum(sizes)), np.cumsum(sizes)[:-1])

    def biases(self, state: State) -> dict[str, Float[np.ndarray, " k"]]:
        """Of gyro (rad/s) and accelerometer (m/s^2), base axes."""
        _, _, b_g, b_a = (state.parts.nuisances[own] for own in self._nuisances)
        return {"gyro": b_g, "accelerometer": b_a}

    def _fresh(
        self,
        t: float,
        R_WB: Float[np.ndarray, "1 3 3"],
        prior: Prior,
        x: Float[np.ndarray, " n"],
    ) -> Parts:
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
        y = self.sets.pi_of_beta.shape[1] + self.sets.sigmas
        return Parts(
            t=np.array([t]),
            w=np.full(3, np.nan),
            R_WB=R_WB,
            top=np.hstack(
                [np.diag(1 / std), np.zeros((x.size, y)), (x / std)[:, None]]
            ),
            R_z=np.zeros((y, y + 1)),
            beta=prior.beta,
            root=prior.root,
            nuisances=x.copy(),
            prior=prior,
        )

    def step(self, state: State, sample: Sample) -> tuple[State, Info]:
        """Take one sample in.

        One that is not complete, or not later than the last one, leaves the state as
        it is; so does one whose rate is the last one's to the last digit: that is how
        a gyro dies, or how a row is written twice.
        """
        packed, info = _step(
            *self._plain, state.sizes, state.packed, sample.t, sample.packed
        )
        return State(state.sizes, packed), Info(*info)

    @cached_property
    def _plain(self) -> tuple:
        """Numba takes tuples without names in a fourth of the time."""
        return plain(self.model), plain(self.noise), plain(self.sets)


@looped
def _step(model, noise, sets, sizes, packed, t, sample):
    """`Extended.step`, compiled."""
    model, noise, sets = model_in(model), Noise(*noise), LinearSets(*sets)
    state, at = parts_of(sizes, packed), measured(model, sample)
    n_h, n_v = len(model.turning), len(model.moving)
    if t <= state.t[0] or not complete(at) or _same(at.w, state.w):
        return packed, (np.zeros(n_h + n_v), 0.0, 0)

    x = state.nuisances
    h_cm = (0.0, 0.0, x[0]) if n_h == 1 else (x[0], x[1], x[2])
    R_WB = quaternion_matrix(at.x_WB[0], at.x_WB[1], at.x_WB[2], at.x_WB[3])
    dt = 0.0 if np.isnan(state.t[0]) else t - state.t[0]
    rows = equations(model, noise, state.beta, h_cm, at, R_WB)
    packed = packed.copy()
    after = parts_of(sizes, packed)
    move_on(model, noise, state, R_WB, h_cm, dt, after.top)
    fold(after.top, rows, 0, sizes[0])
    fold(after.R_z, rows, sizes[0], sizes[1])
    assign(after.nuisances, _nuisances(after.top, _newton(sets, after)))
    after.t[0] = t
    for i in range(3):
        after.w[i] = at.w[i]
        put(after.R_WB[0], i, row(R_WB, 0, i))

    white, nis = np.empty(n_h + n_v), 0.0
    for i in range(len(white)):
        white[i] = rows[i, -1]
        nis += white[i] ** 2
    return packed, (white, nis, n_h + n_v if finite(at.v_S) else n_h)


@looped
def _same(a, b):
    equal = True
    for i in range(len(a)):
        equal = equal and a[i] == b[i]
    return equal


@looped
def _newton(sets, after):
    """A step of Gauss and Newton from the last `beta`, its root, and its `y`."""
    prior, R_z, k, n = after.prior, after.R_z, len(after.beta), len(after.R_z)
    _, tangent = linear_sets_at(sets, after.beta)
    columns, root_z = np.empty((k + 1, n)), np.zeros((k, k + 1))
    for i in range(n):
        for j in range(k):
            columns[j, i] = dot(R_z[i, i:n], tangent[j, i:])
        columns[k, i] = R_z[i, n] + dot(R_z[i, i:n], tangent[k, i:])
    for i in range(k):
        assign(root_z[i, i:k], prior.root[i, i:])
        root_z[i, k] = dot(prior.root[i], prior.beta)
    fold_columns(root_z, columns)
    assign(after.beta, solved(root_z))
    for i in range(k):
        assign(after.root[i], root_z[i])
    y = -tangent[k]
    for j in range(k):
        add_scaled(after.beta[j], tangent[j], y)
    return y


@looped
def _nuisances(top, y):
    """`x` of `N x + Y y = z`."""
    n = len(top)
    N_z = np.empty((n, n + 1))
    for i in range(n):
        assign(N_z[i, :n], top[i])
        N_z[i, n] = top[i, -1]
        for j in range(len(y)):
            N_z[i, n] -= top[i, n + j] * y[j]
    return solved(N_z)


@looped
def _momentum(model, beta, sample):
    """`R_0 (D w + D_q qd + A_rw qd_rw)` (Eq. 2), and `R_0`."""
    at, joints = measured(model, sample), len(model.columns.joints.parent)
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
