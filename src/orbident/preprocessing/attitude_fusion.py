"""The attitude from a gyro: alone, or with what attitude fixes say of its errors.

With `R^` the attitude that the gyro alone gives, `R_WB = exp([phi]x) R^`, and the gyro
wrong by a bias `b` and by white noise of density `N^2` (angle random walk), to first
order in `phi`, inertial axes,

    phi' = -R^ (b + white),   fix: log(R_fix R^T) = phi + N(0, std^2)

Seen from inertial axes the error does not turn with the base. A Kalman smoother finds
it (Rauch, Tung, Striebel 1965). All is repeated about what was found, for large errors.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from orbident import _core
from orbident.errors import InputError
from orbident.preprocessing.integrals import (
    bias_response,
    integrate_gyro,
    span_of,
    start_of_gyro,
    with_nan_outside,
)
from orbident.robot.sensor_schema import GyroSpec

ROUNDS = 3
"""The first leaves errors of second order in `phi`; the third is for large ones."""

UNKNOWN_ATTITUDE = np.pi
"""Std of `phi` beforehand, rad."""


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
    """Deviation of a small turn about each inertial axis, rad."""
    bias: Float[np.ndarray, "n 3"]
    """Bias of the gyro, base axes, rad/s."""
    bias_std: Float[np.ndarray, "n 3"]


def fuse_attitude(
    t: Float[np.ndarray, " n"],
    w: Float[np.ndarray, "n 3"],
    fixes: Float[np.ndarray, "n 4"],
    gyro: GyroNoise,
    std: float,
    source: str = "recording",
) -> Fused:
    """The most likely attitude, given all samples of a gyro and all fixes.

    Args:
        t: times, s.
        w: the gyro's samples, base axes, rad/s; NaN where there is none.
        fixes: attitudes from outside, unit quaternions; NaN where there is none.
        gyro: the gyro's noise.
        std: of a fix, about each axis, rad.
        source: where the samples came from, for messages.

    Raises:
        InputError: the gyro has fewer than four samples, or no fix lies within them.
    """
    measured, fixed = (np.asarray(np.isfinite(x).all(axis=1)) for x in (w, fixes))
    if not measured.any():
        raise InputError(f"{source}: gyro has no samples; give at least 4")
    inside = span_of(measured)
    if not fixed[inside].any():
        raise InputError(
            f"{source}: attitude has no samples while the gyro has; give both"
        )
    found = _fused(t[inside], w[inside], fixes[inside], fixed[inside], gyro, std)
    return Fused(
        x_WB=with_nan_outside(found.x_WB, inside, t.size),
        std=with_nan_outside(np.sqrt(found.variance[:, :3]), inside, t.size),
        bias=with_nan_outside(found.bias, inside, t.size),
        bias_std=with_nan_outside(np.sqrt(found.variance[:, 3:]), inside, t.size),
    )


class _FusionPass(NamedTuple):
    """What one pass of the smoother found, at every row."""

    x_WB: Float[np.ndarray, "n 4"]
    variance: Float[np.ndarray, "n 6"]
    """Variances and covariances of `[phi, b]`."""
    bias: Float[np.ndarray, "n 3"]


def _fused(
    t: np.ndarray,
    w: np.ndarray,
    fixes: np.ndarray,
    fixed: np.ndarray,
    gyro: GyroNoise,
    std: float,
) -> _FusionPass:
    def about(start: np.ndarray, bias: np.ndarray) -> _FusionPass:
        x = integrate_gyro(t, w - bias, start)
        turned = Rotation.from_quat(fixes[fixed]) * Rotation.from_quat(x[fixed]).inv()
        y = np.full((t.size, 3), np.nan)
        y[fixed] = turned.as_rotvec()
        B = np.diff(bias_response(t, x), axis=0)
        noise = np.array([gyro.N, gyro.drift, std])
        before = np.array([UNKNOWN_ATTITUDE, GyroSpec.UNKNOWN_BIAS])
        mean, variance = _core.smooth_gyro_error(B, np.diff(t), y, noise, before)
        fused = Rotation.from_rotvec(mean[:, :3]) * Rotation.from_quat(x)
        return _FusionPass(fused.as_quat(), variance, bias + mean[:, 3:])

    found = about(start_of_gyro(t, w, fixes, fixed), np.zeros(3))
    for _ in range(ROUNDS - 1):
        found = about(found.x_WB[0], found.bias.mean(axis=0))
    return found
