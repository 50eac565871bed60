"""Integrals of what gyro and accelerometer felt, and what their errors make of them."""

import numpy as np
from jaxtyping import Bool, Float
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from orbident import _core
from orbident.errors import InputError
from orbident.model.rotations import UNTURNED

GAUSS = np.sqrt(3) / 6
"""The part of a step from its middle to each of the two Gauss points."""


def integrate_gyro(
    t: Float[np.ndarray, " n"],
    w: Float[np.ndarray, "n 3"],
    x_start: Float[np.ndarray, "4"],
    source: str = "recording",
) -> Float[np.ndarray, "n 4"]:
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
    t: Float[np.ndarray, " n"],
    w: Float[np.ndarray, "n 3"],
    fixes: Float[np.ndarray, "n 4"],
    fixed: Bool[np.ndarray, " n"],
) -> Float[np.ndarray, "4"]:
    """Where the gyro must start to pass through the first fix within its samples."""
    x = integrate_gyro(t, w, UNTURNED)
    k = int((fixed & np.isfinite(x).all(axis=1)).argmax())
    return (Rotation.from_quat(fixes[k]) * Rotation.from_quat(x[k]).inv()).as_quat()


def velocity_from_accelerometer(
    t: Float[np.ndarray, " n"],
    x_WB: Float[np.ndarray, "n 4"],
    f_S: Float[np.ndarray, "n 3"],
    source: str = "recording",
) -> Float[np.ndarray, "n 3"]:
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


def velocity_from_increments(
    x_WB: Float[np.ndarray, "n 4"], dv: Float[np.ndarray, "n 3"]
) -> Float[np.ndarray, "n 3"]:
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


def bias_response(
    t: Float[np.ndarray, " n"], x_WB: Float[np.ndarray, "n 4"]
) -> Float[np.ndarray, "n 3 3"]:
    """How a constant accelerometer bias shows in the integrated velocity.

    `v_S` is wrong by `(integral of R_WB) b`, inertial axes, s.
    """
    R_WB = Rotation.from_quat(x_WB).as_matrix()
    return _integral(t, R_WB.reshape(-1, 9), t).reshape(-1, 3, 3)


def gyro_response(
    t: Float[np.ndarray, " n"],
    x_WB: Float[np.ndarray, "n 4"],
    w: Float[np.ndarray, "n 3"],
) -> Float[np.ndarray, "n 3 12"]:
    """How a gyro's bias `b`, and scale and misalignment `E`, turn its integral.

    The attitude is wrong by `(integral of R_WB) b + (integral of R_WB E w)`, inertial
    axes; the columns are those of `b`, s, and of `E` row by row, rad.
    """
    R_WB = Rotation.from_quat(x_WB).as_matrix()
    E = (R_WB[:, :, :, None] * w[:, None, None, :]).reshape(-1, 3, 9)
    both = np.concatenate([R_WB, E], axis=2)
    return _integral(t, both.reshape(-1, 36), t).reshape(-1, 3, 12)


def _integral(
    t: Float[np.ndarray, " m"],
    rate: Float[np.ndarray, "m columns"],
    at: Float[np.ndarray, " n"],
) -> Float[np.ndarray, "n columns"]:
    """Integral of the cubic spline from `at[0]`; rates are constant beyond the samples.

    A spline that is extrapolated runs away; samples missing at an end are few.
    """
    inside = np.clip(at, t[0], t[-1])
    before, after = np.minimum(at - t[0], 0), np.maximum(at - t[-1], 0)
    # A column lies together, and splines are made one by one: they take much memory.
    integrals = np.empty((rate.shape[1], at.size))
    for integral, column in zip(integrals, rate.T, strict=True):
        integral[:] = CubicSpline(t, column).antiderivative()(inside)
        integral += before * column[0] + after * column[-1]
        integral -= integral[0]
    return integrals.T


def span_of(measured: Bool[np.ndarray, " n"]) -> slice:
    """The rows from the first with a sample to the last."""
    first, last = np.flatnonzero(measured)[[0, -1]]
    return slice(first, last + 1)


def with_nan_outside(values: np.ndarray, where: slice, rows: int) -> np.ndarray:
    """All rows: these values where they are known, NaN elsewhere."""
    every = np.full((rows, values.shape[1]), np.nan)
    every[where] = values
    return every
