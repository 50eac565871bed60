"""Whether the clock of the attitude agrees with that of the gyro.

A fix with the time `t` that shows the world of `t - l` is, to first order, turned back
by `l w`; seen from inertial axes, beside the gyro's own error,

    log(R_fix R^T) = phi_0 - (integral of R^) b - (integral of R^ E w) - l R^ w,

with `R^` by the gyro alone: linear in the start `phi_0`, the gyro's bias `b`, its scale
and misalignment `E`, which would pass for a delay, and the delay `l`. It is repeated
with what was found.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from orbident.preprocessing.attitude_fusion import integrate_gyro
from orbident.preprocessing.delays import Delay, delay_of
from orbident.preprocessing.point_velocity import gyro_response

UNKNOWNS = 16
"""Start, bias, scale and misalignment, and the delay."""

FEWEST = 16
"""Samples of either sensor."""

ROUNDS = 8
SETTLED = 1e-7
"""s."""


def attitude_delay(
    t: Float[np.ndarray, " n"],
    w: Float[np.ndarray, "n 3"],
    fixes: Float[np.ndarray, "n 4"],
    declared: float = 0.0,
) -> Delay | None:
    """How much the times of attitude fixes are behind the gyro's.

    Args:
        t: times, s.
        w: the gyro's samples, base axes, rad/s; NaN where there is none.
        fixes: attitudes from outside, unit quaternions; NaN where there is none.
        declared: by how much they are known to be behind, s.

    Returns:
        What is beyond the declared delay; None where too few fixes are there to tell.
    """
    measured = np.isfinite(w).all(axis=1)
    fixed = np.asarray(np.isfinite(fixes).all(axis=1))
    if measured.sum() < FEWEST or (measured & fixed).sum() < FEWEST:
        return None
    rate = CubicSpline(t[measured], w[measured], extrapolate=False)
    start, bias, late = _start(t, w, fixes, fixed), np.zeros(3), declared
    found = before = None
    for _ in range(ROUNDS):
        x = integrate_gyro(t, w - bias, start)
        known = np.isfinite(x).all(axis=1)
        then = t - late
        if not known.any():
            return None
        usable = fixed & (t[known][0] <= then) & (then <= t[known][-1])
        if usable.sum() < FEWEST:
            return None
        R_then = Rotation.from_quat(CubicSpline(t[known], x[known])(then[usable]))
        error = Rotation.from_quat(fixes[usable]) * R_then.inv()
        shown = rate(t[known]) - bias
        gyro = gyro_response(t[known], x[known], shown)
        B = CubicSpline(t[known], gyro)(then[usable])
        w_then = R_then.apply(rate(then[usable]) - bias)
        found = _solve(error.as_rotvec(), B, w_then)
        before = found.before if before is None else before
        late, bias = late + found.change, bias + found.bias
        start = (Rotation.from_rotvec(found.phi) * Rotation.from_quat(start)).as_quat()
        if abs(found.change) < max(SETTLED, found.std / 10):
            break
    if found is None or before is None:
        return None
    return delay_of(late - declared, found.std, found.change, before, found.after)


def _start(
    t: Float[np.ndarray, " n"],
    w: Float[np.ndarray, "n 3"],
    fixes: Float[np.ndarray, "n 4"],
    fixed: Bool[np.ndarray, " n"],
) -> Float[np.ndarray, "4"]:
    """Where the gyro must start to pass through the first fix after it."""
    x = integrate_gyro(t, w, np.array([0.0, 0.0, 0.0, 1.0]))
    k = int((fixed & np.isfinite(x).all(axis=1)).argmax())
    R_fix, R_k = Rotation.from_quat(fixes[k]), Rotation.from_quat(x[k])
    return (R_fix * R_k.inv()).as_quat()


class _DelayStep(NamedTuple):
    change: float
    std: float
    phi: Float[np.ndarray, "3"]
    bias: Float[np.ndarray, "3"]
    before: float
    """Norm of the residual without a change of the delay."""
    after: float


def _solve(
    y: Float[np.ndarray, "m 3"],
    B: Float[np.ndarray, "m 3 12"],
    w_then: Float[np.ndarray, "m 3"],
) -> _DelayStep:
    start = np.broadcast_to(np.eye(3), (len(y), 3, 3))
    A = np.concatenate([start, -B, -w_then[:, :, None]], axis=2)
    A = A.reshape(-1, UNKNOWNS)
    R = np.asarray(np.linalg.qr(np.column_stack([A, y.ravel()]), mode="r"))
    solution = np.linalg.lstsq(R[:-1, :-1], R[:-1, -1], rcond=None)[0]
    after, own = abs(float(R[-1, -1])), float(abs(R[-2, -2]))
    scatter = after / np.sqrt(y.size - UNKNOWNS)
    # The delay is the last unknown: its deviation is that of its own row.
    return _DelayStep(
        change=float(solution[-1]),
        std=scatter / own if own else np.inf,
        phi=solution[:3],
        bias=solution[3:6],
        before=float(np.hypot(after, R[-2, -1])),
        after=after,
    )
