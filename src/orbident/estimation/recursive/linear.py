"""Square-root recursive least squares for `pi` (Eq. 24) and `phi` (Eq. 31).

    [Y | -R_0^T] [pi, h_cm] = -A_rw qd_rw
    [R_0^T | R_0^T drift | W] [v_cm, b_a, phi] = R_0^T v_S

The triangular factors of all rows are carried; every row counts alike, so that with no
forgetting they are what least squares of the whole recording makes.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.dynamics.loops.bodies import move, place, room
from orbident.dynamics.loops.matrices import finite
from orbident.dynamics.loops.vectors import quaternion_matrix, rotated_back
from orbident.errors import InputError
from orbident.estimation.recursive.equations import (
    Model,
    complete,
    measured,
    model_of,
    momentum_of_wheels,
    put_rotation,
    rates_at,
)
from orbident.estimation.recursive.folding import fold
from orbident.estimation.recursive.sample import Sample
from orbident.estimation.triangular import Layout, LinearFit, solve
from orbident.loops import looped
from orbident.regressors.loops import regressors
from orbident.regressors.minimal_sets import MinimalSets
from orbident.robot.description import Robot


class LinearState(NamedTuple):
    """Triangular factors of `[nuisances | parameters | right-hand side]`."""

    R_h: Float[np.ndarray, "h h"]
    R_v: Float[np.ndarray, "v v"]
    weight_h: float
    """Rows that went in, forgotten ones counted as what is left of them."""
    weight_v: float


class LinearInfo(NamedTuple):
    """What one sample added to the squared residuals.

    They are its innovations, squared, over their variances for noise of unit variance.
    """

    momentum: float
    velocity: float


@dataclass(frozen=True)
class Linear:
    """The recursive least squares of one robot."""

    model: Model
    pi: Layout
    phi: Layout
    forgetting: float

    @classmethod
    def of(
        cls,
        robot: Robot,
        sets: MinimalSets,
        accelerometer: bool,
        forgetting: float = 1.0,
    ) -> "Linear":
        """The recursive least squares of a robot.

        Args:
            robot: geometry and wheels.
            sets: its minimal sets.
            accelerometer: whether `v_S` is integrated from one, whose bias is unknown.
            forgetting: what a row counts a sample later, squared; 1 never forgets.

        Raises:
            InputError: `forgetting` is not above 0 and at most 1.
        """
        if not 0.0 < forgetting <= 1.0:
            raise InputError(
                f"forgetting: found {forgetting}; give a number above 0 and at most 1"
            )
        h, v = sets.regressors.momentum_axes, sets.regressors.velocity_axes
        return cls(
            model=model_of(robot, sets),
            pi=Layout(len(h), len(sets.pi_of_beta), 0),
            phi=Layout(len(v) * (2 if accelerometer else 1), sets.base.sigmas, 0),
            forgetting=float(forgetting),
        )

    def start(self) -> LinearState:
        """Nothing is known."""
        R_h, R_v = (np.zeros((k.columns,) * 2) for k in (self.pi, self.phi))
        return LinearState(R_h, R_v, 0.0, 0.0)

    def step(
        self, state: LinearState, sample: Sample
    ) -> tuple[LinearState, LinearInfo]:
        """Take one sample in, in any order; one that is not complete is left out."""
        return _step(
            self.model, self.phi.nuisances, self.forgetting, state, sample.packed
        )

    def estimate(self, state: LinearState) -> tuple[LinearFit, LinearFit]:
        """`pi` and `phi` with their covariances, as `least_squares.fit` gives them."""
        return (
            solve(state.R_h, self.pi, round(state.weight_h)),
            solve(state.R_v, self.phi, round(state.weight_v)),
        )


@looped
def _step(model, nuisances, forgetting, state, packed):
    """`Linear.step`, compiled; so many nuisances has the velocity."""
    at = measured(model, packed)
    if not complete(at):
        return state, LinearInfo(0.0, 0.0)
    joints, n_h, n_v = len(at.q), len(model.turning), len(model.moving)
    bodies, motion = room(joints + 1), np.empty((2, joints + 1, 3))
    place(model.columns.joints, at.q, bodies)
    move(model.columns.joints, bodies, motion, rates_at(at.w, at.qd))
    Y, W = regressors(model.columns, bodies, motion)
    R_WB = quaternion_matrix(at.x_WB[0], at.x_WB[1], at.x_WB[2], at.x_WB[3])

    rows_h, h_rw = np.zeros((n_h, len(state.R_h))), momentum_of_wheels(model, at)
    for i in range(n_h):
        axis = model.turning[i]
        put_rotation(R_WB, model.turning, axis, -1.0, rows_h[i], 0)
        for k in range(Y.shape[1]):
            rows_h[i, n_h + k] = Y[axis, k]
        rows_h[i, -1] = -h_rw[axis]
    v_S = rotated_back(R_WB, 0, (at.v_S[0], at.v_S[1], at.v_S[2]))
    moving, rows_v = finite(at.v_S), np.zeros((n_v, len(state.R_v)))
    for i in range(n_v if moving else 0):
        axis = model.moving[i]
        put_rotation(R_WB, model.moving, axis, 1.0, rows_v[i], 0)
        for k in range(n_v, nuisances):
            # Of an accelerometer's bias.
            for j in range(3):
                drift = at.drift[3 * j + model.moving[k - n_v]]
                rows_v[i, k] += R_WB[0, j, axis] * drift
        for k in range(W.shape[1]):
            rows_v[i, nuisances + k] = W[axis, k]
        rows_v[i, -1] = v_S[axis]

    R_h, added_h = _folded(state.R_h, rows_h, forgetting)
    R_v, added_v = _folded(state.R_v, rows_v, forgetting)
    after = LinearState(
        R_h,
        R_v,
        forgetting * state.weight_h + n_h,
        forgetting * state.weight_v + (n_v if moving else 0),
    )
    return after, LinearInfo(added_h, added_v)


@looped
def _folded(R, rows, forgetting):
    """With some more rows, and by how much the squared residual grew."""
    after, n = np.empty(R.shape), len(R)
    for i in range(n):
        for j in range(n):
            after[i, j] = np.sqrt(forgetting) * R[i, j]
    fold(after, rows, 0, n)
    return after, after[-1, -1] ** 2 - forgetting * R[-1, -1] ** 2
