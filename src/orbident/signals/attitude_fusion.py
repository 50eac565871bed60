"""Gyro and attitude fixes together: a Kalman smoother of what the gyro got wrong.

With `R^` the attitude that the gyro alone gives, `R_WB = exp([phi]x) R^`, and the gyro
wrong by a bias `b` and by white noise of density `N^2` (angle random walk), to first
order in `phi`, inertial axes,

    phi' = -R^ (b + white),   fix: log(R_fix R^T) = phi + N(0, std^2)

Seen from inertial axes the error does not turn with the base. All is repeated about
what was found, for large errors.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from orbident.errors import InputError
from orbident.precision import in_float64
from orbident.signals.gyro_integration import integrate_gyro
from orbident.signals.kalman import Model, smoothed
from orbident.signals.velocity import bias_response

ROUNDS = 3
"""The first leaves errors of second order in `phi`; the third is for large ones."""

UNKNOWN_ATTITUDE = np.pi
"""Std of `phi` beforehand, rad."""

UNKNOWN_BIAS = 0.1
"""Std of the bias beforehand, rad/s: more than any gyro's."""


class GyroNoise(NamedTuple):
    """How far a gyro is to be trusted."""

    N: float
    """Angle random walk, rad/sqrt(s)."""
    drift: float = 0.0
    """Random walk of the bias, rad/s/sqrt(s)."""


class Fused(NamedTuple):
    """The attitude at every row within the gyro's samples; NaN outside."""

    x_WB: Float[np.ndarray, "n 4"]
    std: Float[np.ndarray, "n 3"]
    """Of a small turn about each inertial axis, rad."""
    bias: Float[np.ndarray, "n 3"]
    """Of the gyro, base axes, rad/s."""
    bias_std: Float[np.ndarray, "n 3"]


@in_float64
def fuse_attitude(
    t: Float[np.ndarray, " n"],
    w: Float[np.ndarray, "n 3"],
    fixes: Float[np.ndarray, "n 4"],
    gyro: GyroNoise,
    std: float,
) -> Fused:
    """The most likely attitude, given all samples of a gyro and all fixes.

    Args:
        t: times, s.
        w: the gyro's samples, base axes, rad/s; NaN where there is none.
        fixes: attitudes from outside, unit quaternions; NaN where there is none.
        gyro: the gyro's noise.
        std: of a fix, about each axis, rad.

    Raises:
        InputError: the gyro has fewer than four samples, or no fix lies within them.
    """
    measured = np.isfinite(w).all(axis=1)
    fixed = np.isfinite(fixes).all(axis=1)
    if not measured.any():
        raise InputError("gyro has no samples; give at least 4")
    first, last = np.flatnonzero(measured)[[0, -1]]
    rows = np.arange(t.size)
    fixed &= (first <= rows) & (rows <= last)
    if not fixed.any():
        raise InputError("attitude has no samples while the gyro has; give both")
    inside = np.s_[first : last + 1]
    found = _fused(t[inside], w[inside], fixes[inside], fixed[inside], gyro, std)
    return Fused(
        x_WB=_placed(found.x_WB, inside, t.size),
        std=_placed(np.sqrt(found.variance[:, :3]), inside, t.size),
        bias=_placed(found.bias, inside, t.size),
        bias_std=_placed(np.sqrt(found.variance[:, 3:]), inside, t.size),
    )


class _Round(NamedTuple):
    """What one pass of the smoother found, at every row."""

    x_WB: Float[np.ndarray, "n 4"]
    variance: Float[np.ndarray, "n 6"]
    """Of `[phi, b]`."""
    bias: Float[np.ndarray, "n 3"]


def _fused(
    t: np.ndarray,
    w: np.ndarray,
    fixes: np.ndarray,
    fixed: np.ndarray,
    gyro: GyroNoise,
    std: float,
) -> _Round:
    def about(start: np.ndarray, bias: np.ndarray) -> _Round:
        x = integrate_gyro(t, w - bias, start)
        turned = Rotation.from_quat(fixes[fixed]) * Rotation.from_quat(x[fixed]).inv()
        y = np.zeros((t.size, 3))
        y[fixed] = turned.as_rotvec()
        mean, variance = smoothed(_model(t, x, gyro), y, fixed, std)
        fused = Rotation.from_rotvec(mean[:, :3]) * Rotation.from_quat(x)
        return _Round(fused.as_quat(), variance, bias + mean[:, 3:])

    found = about(_start(t, w, fixes, fixed), np.zeros(3))
    for _ in range(ROUNDS - 1):
        found = about(found.x_WB[0], found.bias.mean(axis=0))
    return found


def _start(
    t: np.ndarray, w: np.ndarray, fixes: np.ndarray, fixed: np.ndarray
) -> np.ndarray:
    """Where the gyro must start to pass through the first fix."""
    k = int(fixed.argmax())
    x = Rotation.from_quat(integrate_gyro(t, w, np.array([0.0, 0.0, 0.0, 1.0]))[k])
    return (Rotation.from_quat(fixes[k]) * x.inv()).as_quat()


def _model(t: np.ndarray, x: np.ndarray, gyro: GyroNoise) -> Model:
    """Of the state `[phi, b]` from each row to the next."""
    h = np.diff(t)
    F = np.tile(np.eye(6), (h.size, 1, 1))
    F[:, :3, 3:] = -np.diff(bias_response(t, x), axis=0)
    q = np.repeat([[gyro.N**2, gyro.drift**2]], 3, axis=1)
    before = np.repeat([UNKNOWN_ATTITUDE**2, UNKNOWN_BIAS**2], 3)
    return Model(F=F, Q=h[:, None] * q, before=before)


def _placed(values: np.ndarray, where: slice, rows: int) -> np.ndarray:
    placed = np.full((rows, values.shape[1]), np.nan)
    placed[where] = values
    return placed
