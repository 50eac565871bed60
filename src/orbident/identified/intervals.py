"""How far a prediction may be off, as the identified parameters may be off.

To first order in `beta`, along each column of a root of its covariance. With `b = R_0^T
h_cm` and `f` the turn by which the predicted attitude is off, base axes:

    D dw = R_0^T dh_cm - dY pi + b x f,   f' = dw - w x f,   f(0) = 0
    dv_S = R_0 (f x W phi + d(W phi)/dw dw + W dphi) + dv_cm

The constants of the motion are means over the recording (see `predict`), and so are
their derivatives. The noise of what was measured is not in it.
"""

from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from orbident.compilation import compiled
from orbident.dynamics.batches import in_batches
from orbident.dynamics.wheels import wheels_of
from orbident.estimation.result import Result
from orbident.identified.prediction import Prediction
from orbident.precision import in_float64
from orbident.regressors.derivatives import derivatives_of_beta
from orbident.regressors.minimal_sets import Regressors, minimal_sets
from orbident.regressors.reconstruction import root_of
from orbident.spatial.arrays import AnyArray
from orbident.spatial.rotations import cross_matrix, quaternion_matrix


class Deviations(NamedTuple):
    """Standard deviations of a prediction."""

    w: Float[np.ndarray, "n 3"]
    """Base rate, base axes, rad/s."""
    v_S: Float[np.ndarray, "n 3"]
    """Velocity of S, inertial axes, m/s."""


class _Terms(NamedTuple):
    """Momentum and velocity at some states, and along the columns of the root."""

    R: Float[AnyArray, "*n 3 3"]
    D: Float[AnyArray, "*n 3 3"]
    h: Float[AnyArray, "*n 3"]
    dh: Float[AnyArray, "*n 3 r"]
    v: Float[AnyArray, "*n 3"]
    v_w: Float[AnyArray, "*n 3 3"]
    """Derivative of `v = W phi` by the base rate."""
    dv: Float[AnyArray, "*n 3 r"]


@in_float64
def deviations(result: Result, prediction: Prediction) -> Deviations:
    """The standard deviations of what was predicted; NaN without a covariance.

    Args:
        result: that predicted.
        prediction: its own, of any recording.
    """
    robot, sets = result.robot, minimal_sets(result.robot)
    root = root_of(result.base_covariance)
    dpi, dphi = derivatives_of_beta(sets, result.base.values)
    along = partial(
        _terms,
        *(sets.regressors, result.pi.values, result.phi.values),
        *(dpi @ root, dphi @ root),
    )
    seen = prediction.measured
    at = in_batches(along, seen.q, seen.qd, seen.w, seen.x_WB, size=BATCH)
    dh_cm = (at.R @ at.dh).mean(axis=0)
    moving = seen.moving if seen.moving.any() else np.ones(seen.moving.size, bool)
    dv_cm = -(at.R @ at.dv)[moving].mean(axis=0)

    at = in_batches(along, seen.q, seen.qd, prediction.w, prediction.x_WB, size=BATCH)
    b = at.h + seen.qd_rw @ wheels_of(robot).A_rw.T
    turning = np.isin(np.arange(3), sets.regressors.momentum_axes)
    D = at.D + np.diag(~turning)
    # dw = dw_0 + B f; in the plane neither tilts.
    R_T = np.swapaxes(at.R, 1, 2)
    dw_0 = np.linalg.solve(D, R_T @ dh_cm - at.dh) * turning[:, None]
    B = np.linalg.solve(D, np.asarray(cross_matrix(b))) * turning[:, None]
    f = _turns(prediction.t, B - np.asarray(cross_matrix(prediction.w)), dw_0)
    dw = dw_0 + B @ f
    off = at.v_w @ dw + at.dv - np.asarray(cross_matrix(at.v)) @ f
    dv = at.R @ off + dv_cm
    return Deviations(np.linalg.norm(dw, axis=2), np.linalg.norm(dv, axis=2))


BATCH = 128
"""States at once: each has a regressor of its own."""


def _turns(
    t: Float[np.ndarray, " n"],
    A: Float[np.ndarray, "n 3 3"],
    c: Float[np.ndarray, "n 3 r"],
) -> Float[np.ndarray, "n 3 r"]:
    """`f' = A f + c` from zero, by the trapezoidal rule: stable, of second order."""
    f, eye = np.zeros_like(c), np.eye(3)
    for k, half in enumerate(np.diff(t) / 2):
        known = f[k] + half * (A[k] @ f[k] + c[k] + c[k + 1])
        f[k + 1] = np.linalg.solve(eye - half * A[k + 1], known)
    return f


@compiled
def _terms(
    regressors: Regressors,
    pi: Float[AnyArray, " pi"],
    phi: Float[AnyArray, " phi"],
    dpi: Float[AnyArray, "pi r"],
    dphi: Float[AnyArray, "phi r"],
    q: Float[AnyArray, "n joints"],
    qd: Float[AnyArray, "n joints"],
    w: Float[AnyArray, "n 3"],
    x_WB: Float[AnyArray, "n 4"],
) -> _Terms:
    turning, moving = regressors.momentum_axes, regressors.velocity_axes

    def terms(q, qd, w, x_WB):
        def momentum_and_velocity(w):
            Y, W = regressors(q, qd, w)
            h = jnp.zeros(3).at[turning,].set(Y @ pi)
            return h, jnp.zeros(3).at[moving,].set(W @ phi)

        Y, W = regressors(q, qd, w)
        h, v = momentum_and_velocity(w)
        D, v_w = jax.jacfwd(momentum_and_velocity)(w)
        none = jnp.zeros((3, dpi.shape[1]))
        dh, dv = none.at[turning,].set(Y @ dpi), none.at[moving,].set(W @ dphi)
        return _Terms(quaternion_matrix(x_WB), D, h, dh, v, v_w, dv)

    return jax.vmap(terms)(q, qd, w, x_WB)
