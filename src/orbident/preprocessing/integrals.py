"""Integrals of what gyro and accelerometer felt, and what their errors make of them.

With `R^` the attitude that the gyro alone gives, `R_WB = exp([phi]x) R^`, and the gyro
wrong by a bias `b` and by white noise of density `N^2` (angle random walk), to first
order in `phi`, inertial axes,

    phi' = -R^ (b + white),   fix: log(R_fix R^T) = phi + N(0, std^2)

Seen from inertial axes the error does not turn with the base. A Kalman smoother finds
it from attitude fixes (Rauch, Tung, Striebel 1965). All is repeated about what was
found, for large errors.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from orbident import _core
from orbident.errors import InputError
from orbident.model.rotations import UNTURNED
from orbident.robot.sensor_schema import GyroSpec

Times = Float[np.ndarray, " n"]
"""Times of samples, s."""
Vectors = Float[np.ndarray, "n 3"]
"""At these times."""
Attitudes = Float[np.ndarray, "n 4"]
"""Quaternions at these times, scalar last."""

AT_ONCE = 100_000
"""Samples of splines that are made at once: some 10 MB."""

GAUSS = np.sqrt(3) / 6
"""The part of a step from its middle to each of the two Gauss points."""


def integrate_gyro(
    t: Times, w: Vectors, x_start: Float[np.ndarray, "4"], source: str = "recording"
) -> Attitudes:
    """The attitude whose rate is the cubic spline through the gyro's samples.

    By the fourth-order Magnus expansion (Iserles et al. 2000), from one row to the
    next, with `w_1`, `w_2` at the two Gauss points of the step `h`:

        x(t + h) = x(t) (x) exp(h/2 (w_1 + w_2) + sqrt(3)/12 h^2 w_1 x w_2)

    Args:
        t: times, s.
        w: angular rate of the base, base axes, rad/s; NaN where there is no sample.
        x_start: attitude at the gyro's first sample, unit quaternion, scalar last.
        source: where the samples came from, for messages.

    Returns:
        Unit quaternions; NaN before the first and after the last sample.

    Raises:
        InputError: the gyro has fewer than four samples.
    """
    measured = np.asarray(np.isfinite(w).all(axis=1))
    if measured.sum() < 4:
        raise InputError(
            f"{source}: gyro has {measured.sum()} samples; give at least 4"
        )
    rate = CubicSpline(t[measured], w[measured])
    inside = span_of(measured)
    h = np.diff(t[inside])
    middle = t[inside][:-1] + h / 2
    w_1, w_2 = rate(middle - GAUSS * h), rate(middle + GAUSS * h)
    return with_nan_outside(_core.integrate_rate(x_start, h, w_1, w_2), inside, t.size)


def start_of_gyro(
    t: Times, w: Vectors, fixes: Attitudes, fixed: Bool[np.ndarray, " n"]
) -> Float[np.ndarray, "4"]:
    """Where the gyro must start to pass through the first fix within its samples."""
    x = integrate_gyro(t, w, UNTURNED)
    k = int((fixed & np.isfinite(x).all(axis=1)).argmax())
    return (Rotation.from_quat(fixes[k]) * Rotation.from_quat(x[k]).inv()).as_quat()


def velocity_from_accelerometer(
    t: Times, x_WB: Attitudes, f_S: Vectors, source: str = "recording"
) -> Vectors:
    """What S's velocity changed by since the first sample.

    `v_S(t) - v_S(t_0) = integral of R_WB f_S`: in free fall specific force is all of
    S's acceleration. By the cubic spline through the samples, across gaps too.

    Args:
        t: times, s.
        x_WB: attitude of the base.
        f_S: specific force at S, base axes, m/s^2; NaN where there is no sample.
        source: where the samples came from, for messages.

    Returns:
        Inertial axes, m/s.

    Raises:
        InputError: there are fewer than four samples.
    """
    measured = np.isfinite(f_S).all(axis=1)
    if measured.sum() < 4:
        raise InputError(
            f"{source}: accelerometer has {measured.sum()} samples; give at least 4"
        )
    f_W = Rotation.from_quat(x_WB[measured]).apply(f_S[measured])
    return _integral(t[measured], f_W, t)


def velocity_from_increments(x_WB: Attitudes, dv: Vectors) -> Vectors:
    """The same from velocity increments, each in the base axes of the sample before.

    `v_S(t_k) - v_S(t_{k-1}) = R_WB(t_{k-1}) dv_k`.

    Args:
        x_WB: attitude of the base.
        dv: since the sample before, m/s; that of the first sample does not count.

    Returns:
        Inertial axes, m/s; NaN from the first missing increment on: what S did in
        between is not known.
    """
    steps = Rotation.from_quat(x_WB[:-1]).apply(dv[1:])
    return np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])


def bias_response(t: Times, x_WB: Attitudes) -> Float[np.ndarray, "n 3 3"]:
    """How a constant accelerometer bias shows in the integrated velocity.

    `v_S` is wrong by `(integral of R_WB) b`, inertial axes, s.
    """
    R_WB = Rotation.from_quat(x_WB).as_matrix()
    return _integral(t, R_WB.reshape(-1, 9), t).reshape(-1, 3, 3)


def gyro_response(t: Times, x_WB: Attitudes, w: Vectors) -> Float[np.ndarray, "n 3 12"]:
    """How a gyro's bias `b`, and scale and misalignment `E`, turn its integral.

    The attitude is wrong by `(integral of R_WB) b + (integral of R_WB E w)`, inertial
    axes; the columns are those of `b`, s, and of `E` row by row, rad.
    """
    R_WB = Rotation.from_quat(x_WB).as_matrix()
    E = (R_WB[:, :, :, None] * w[:, None, None, :]).reshape(-1, 3, 9)
    both = np.concatenate([R_WB, E], axis=2)
    return _integral(t, both.reshape(-1, 36), t).reshape(-1, 3, 12)


def _integral(
    t: Float[np.ndarray, " m"], rate: Float[np.ndarray, "m columns"], at: Times
) -> Float[np.ndarray, "n columns"]:
    """Integral of the cubic spline from `at[0]`; rates are constant beyond the samples.

    A spline that is extrapolated runs away; samples missing at an end are few.
    """
    inside = np.clip(at, t[0], t[-1])
    before, after = np.minimum(at - t[0], 0), np.maximum(at - t[-1], 0)
    # Splines of many samples take much memory: so many columns at once.
    integrals, some = np.empty((at.size, rate.shape[1])), max(AT_ONCE // t.size, 1)
    for first in range(0, rate.shape[1], some):
        columns = rate[:, first : first + some]
        integral = CubicSpline(t, columns).antiderivative()(inside)
        integral += np.outer(before, columns[0]) + np.outer(after, columns[-1])
        integrals[:, first : first + some] = integral - integral[0]
    return integrals


def span_of(measured: Bool[np.ndarray, " n"]) -> slice:
    """The rows from the first with a sample to the last."""
    first, last = np.flatnonzero(measured)[[0, -1]]
    return slice(first, last + 1)


def with_nan_outside(values: np.ndarray, where: slice, rows: int) -> np.ndarray:
    """All rows: these values where they are known, NaN elsewhere."""
    every = np.full((rows, values.shape[1]), np.nan)
    every[where] = values
    return every


ROUNDS = 3
"""The first leaves errors of second order in `phi`; the third is for large ones."""

UNKNOWN_ATTITUDE = np.pi
"""Std of `phi` beforehand, rad."""

PIECES = 40
"""So many parts of a recording last about a second each, in which a base turns by more
than the noise of an attitude sensor."""


class GyroNoise(NamedTuple):
    """How far a gyro is to be trusted."""

    N: float
    """Angle random walk, rad/sqrt(s)."""
    drift: float = 0.0
    """Random walk of the bias, rad/s/sqrt(s)."""


class Fused(NamedTuple):
    """The attitude at every row within the gyro's samples; NaN outside."""

    x_WB: Attitudes
    std: Vectors
    """Deviation of a small turn about each inertial axis, rad."""
    bias: Vectors
    """Bias of the gyro, base axes, rad/s."""
    bias_std: Vectors


def fuse_attitude(
    t: Times,
    w: Vectors,
    fixes: Attitudes,
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
    # Sensors without noise leave rounding, of either sign.
    every = with_nan_outside(np.sqrt(np.maximum(found.variance, 0.0)), inside, t.size)
    return Fused(
        x_WB=with_nan_outside(found.x_WB, inside, t.size),
        std=every[:, :3],
        bias=with_nan_outside(found.bias, inside, t.size),
        bias_std=every[:, 3:],
    )


class _FusionPass(NamedTuple):
    """What one pass of the smoother found, at every row."""

    x_WB: Attitudes
    variance: Float[np.ndarray, "n 6"]
    """Variances and covariances of `[phi, b]`."""
    bias: Vectors


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


class Turned(NamedTuple):
    """How a base turned, piece by piece, by each of two sensors: rotation vectors."""

    by_gyro: Float[np.ndarray, "pieces 3"]
    """rad; in the base's axes at the beginning of each piece."""
    by_attitude: Float[np.ndarray, "pieces 3"]

    @property
    def apart(self) -> float:
        """The part of the turning in which they differ; not a number without any.

        It is 0 where they agree, and about 1 where one says nothing of the other.
        """
        gyro, attitude = (Rotation.from_rotvec(each) for each in self)
        whole = np.linalg.norm(self)
        return float(
            np.linalg.norm((gyro.inv() * attitude).magnitude()) / whole
            if whole
            else np.nan
        )

    @property
    def ratio(self) -> float:
        """How many times what the attitude shows the gyro does; 0 where they differ."""
        both = float(np.sum(self.by_gyro * self.by_attitude))
        return both / float(np.sum(self.by_attitude**2)) if both else 0.0


def turned(t: Times, w: Vectors, x_WB: Attitudes) -> Turned:
    """How gyro and attitude turn from one piece to the next; no robot is needed.

    Args:
        t: times, s.
        w: what the gyro shows, rad/s; NaN where there is no sample.
        x_WB: what the attitude sensor does, unit quaternions; NaN likewise.
    """
    by_gyro = integrate_gyro(t, w, UNTURNED)
    both = np.flatnonzero(np.isfinite(np.hstack([by_gyro, x_WB])).all(axis=1))
    at = both[:: max(both.size // PIECES, 1)]
    every = Rotation.from_quat(by_gyro[at]), Rotation.from_quat(x_WB[at])
    return Turned(*((R[:-1].inv() * R[1:]).as_rotvec() for R in every))
