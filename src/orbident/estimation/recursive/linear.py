"""Square-root recursive least squares for `pi` (Eq. 24) and `phi` (Eq. 31).

    [Y | -R_0^T] [pi, h_cm] = -A_rw qd_rw
    [R_0^T | R_0^T drift | W] [v_cm, b_a, phi] = R_0^T v_S

The triangular factors of all rows are carried; every row counts alike, so that with no
forgetting they are what least squares of the whole recording makes.
"""

from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from orbident.dynamics.wheels import Wheels, wheels_of
from orbident.errors import InputError
from orbident.estimation.least_squares import rows_of
from orbident.estimation.recursive.sample import Sample
from orbident.estimation.triangular import Layout, LinearFit, fold, solve
from orbident.precision import in_float64
from orbident.regressors.minimal_sets import MinimalSets, Regressors
from orbident.robot.description import Robot
from orbident.signals.samples import Batch


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

    regressors: Regressors
    wheels: Wheels
    pi: Layout
    phi: Layout
    forgetting: float

    @classmethod
    @in_float64
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
            # On JAX's side once and for all, not at every step.
            regressors=jax.tree.map(jnp.asarray, sets.regressors),
            wheels=jax.tree.map(jnp.asarray, wheels_of(robot)),
            pi=Layout(len(h), len(sets.pi_of_beta), 0),
            phi=Layout(len(v) * (2 if accelerometer else 1), sets.base.sigmas, 0),
            forgetting=forgetting,
        )

    def start(self) -> LinearState:
        """Nothing is known."""
        R_h, R_v = (np.zeros((k.columns,) * 2) for k in (self.pi, self.phi))
        return LinearState(R_h, R_v, 0.0, 0.0)

    def step(
        self, state: LinearState, sample: Sample
    ) -> tuple[LinearState, LinearInfo]:
        """Take one sample in, in any order; one that is not complete is left out."""
        batch = _batch(sample)
        if not batch.turning[0]:
            return state, LinearInfo(0.0, 0.0)
        biased = self.phi.nuisances > len(self.regressors.velocity_axes)
        with jax.enable_x64(True):
            rows = rows_of(self.regressors, self.wheels, None, batch, biased)
        rows_h, rows_v = (np.asarray(part) for part in rows)
        keep = np.sqrt(self.forgetting)
        R_h, R_v = fold(keep * state.R_h, rows_h), fold(keep * state.R_v, rows_v)
        after = LinearState(
            R_h,
            R_v,
            self.forgetting * state.weight_h + len(rows_h),
            self.forgetting * state.weight_v + len(rows_v) * bool(batch.moving[0]),
        )
        added = (
            float(R[-1, -1] ** 2 - self.forgetting * before[-1, -1] ** 2)
            for R, before in ((R_h, state.R_h), (R_v, state.R_v))
        )
        return after, LinearInfo(*added)

    def estimate(self, state: LinearState) -> tuple[LinearFit, LinearFit]:
        """`pi` and `phi` with their covariances, as `least_squares.fit` gives them."""
        return (
            solve(state.R_h, self.pi, round(state.weight_h)),
            solve(state.R_v, self.phi, round(state.weight_v)),
        )


def _batch(sample: Sample) -> Batch:
    """One sample in the form that the rows are made from."""
    parts = (sample.q, sample.qd, sample.w, sample.x_WB, sample.qd_rw)
    turning = all(np.isfinite(part).all() for part in parts)
    moving = turning and bool(np.isfinite(sample.v_S).all())
    v_S = sample.v_S if moving else np.zeros(3)
    values = (*parts, v_S, sample.drift)
    q, qd, w, x_WB, qd_rw, v_S, drift = (
        np.asarray(value, dtype=np.float64)[None] for value in values
    )
    flags = np.array([turning]), np.array([moving])
    return Batch(q, qd, w, x_WB, qd_rw, v_S, drift, *flags)
