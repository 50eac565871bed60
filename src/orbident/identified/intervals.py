"""How far a prediction may be off, as the identified parameters may be off.

To first order in `beta`, along each column of a root of its covariance. With `b = R_0^T
h_cm` and `f` the turn by which the predicted attitude is off, base axes:

    D dw = R_0^T dh_cm - dY pi + b x f,   f' = dw - w x f,   f(0) = 0
    dv_S = R_0 (f x W phi + d(W phi)/dw dw + W dphi) + dv_cm

The constants of the motion are means over the recording (see `predict`), and so are
their derivatives. The noise of what was measured is not in it.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.estimation.result import Result
from orbident.identified.prediction import Prediction, momentum_terms, parts_of
from orbident.model.derivatives import derivatives_of_beta
from orbident.model.minimal_sets import Regressors, minimal_sets
from orbident.model.reconstruction import root_of
from orbident.model.rotations import quaternion_matrix, rotate
from orbident.model.wheel_arrays import wheels_of
from orbident.robot.parameters import cross_matrix


class PredictionDeviations(NamedTuple):
    """Standard deviations of a prediction."""

    w: Float[np.ndarray, "n 3"]
    """Base rate, base axes, rad/s."""
    v_S: Float[np.ndarray, "n 3"]
    """Velocity of S, inertial axes, m/s."""


class _Changes(NamedTuple):
    """How `h_rs` and `v_S` (relative to the CM) change along the columns of a root."""

    dh: Float[np.ndarray, "n 3 r"]
    dv: Float[np.ndarray, "n 3 r"]


def prediction_deviations(
    result: Result, prediction: Prediction
) -> PredictionDeviations:
    """The standard deviations of what was predicted; NaN without a covariance.

    Args:
        result: that predicted.
        prediction: its own, of any recording.
    """
    robot, sets = result.robot, minimal_sets(result.robot)
    root = root_of(result.base_covariance)
    dpi, dphi = derivatives_of_beta(sets, result.base.values)
    regressors, roots = sets.regressors, (dpi @ root, dphi @ root)
    seen = prediction.measured
    R = quaternion_matrix(seen.x_WB)
    dh, dv = _changes(regressors, roots, seen.q, seen.qd, seen.w)
    dh_cm = (R @ dh).mean(axis=0)
    moving = seen.moving if seen.moving.any() else np.ones(seen.moving.size, bool)
    dv_cm = -(R @ dv)[moving].mean(axis=0)

    pi, phi = result.pi.values, result.phi.values
    at = momentum_terms(regressors, pi, phi, seen.q, seen.qd)
    w, R = prediction.w, quaternion_matrix(prediction.x_WB)
    dh, dv = _changes(regressors, roots, seen.q, seen.qd, w)
    b = rotate(at.D, w) + at.h_q + seen.qd_rw @ wheels_of(robot).A_rw.T
    turning = np.isin(np.arange(3), regressors.momentum_axes)
    D = at.D + np.diag(~turning)
    # dw = dw_0 + B f; in the plane neither tilts.
    dw_0 = np.linalg.solve(D, np.swapaxes(R, 1, 2) @ dh_cm - dh) * turning[:, None]
    B = np.linalg.solve(D, cross_matrix(b)) * turning[:, None]
    f = _turns(prediction.t, B - cross_matrix(w), dw_0)
    dw = dw_0 + B @ f
    v = rotate(at.V, w) + at.v_q
    off = at.V @ dw + dv - cross_matrix(v) @ f
    dv = R @ off + dv_cm
    return PredictionDeviations(np.linalg.norm(dw, axis=2), np.linalg.norm(dv, axis=2))


def _changes(
    regressors: Regressors,
    roots: tuple[Float[np.ndarray, "pi r"], Float[np.ndarray, "phi r"]],
    q: Float[np.ndarray, "n joints"],
    qd: Float[np.ndarray, "n joints"],
    w: Float[np.ndarray, "n 3"],
) -> _Changes:
    dpi, dphi = roots
    dh, dv = np.zeros((2, len(q), 3, dpi.shape[1]))
    for part in parts_of(len(q)):
        Y, W = regressors(q[part], qd[part], w[part])
        dh[part, list(regressors.momentum_axes)] = Y @ dpi
        dv[part, list(regressors.velocity_axes)] = W @ dphi
    return _Changes(dh, dv)


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
