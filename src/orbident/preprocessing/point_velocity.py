"""The velocity of S at the rows of a recording.

It is declared, or follows from what an accelerometer at S felt.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from orbident.errors import InputError
from orbident.preprocessing.histories import Columns
from orbident.preprocessing.origins import Origin
from orbident.preprocessing.rates import at_times
from orbident.preprocessing.smoothing import Settings, fits_of, smooth_rates
from orbident.recordings.recording import Recording


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


class PointVelocity(NamedTuple):
    """Columns; empty where they cannot be had."""

    v_S: Columns
    """Inertial axes, m/s; but for a constant where it is derived from forces."""
    origin: Origin


def point_velocity(
    recording: Recording,
    x_WB: Columns,
    delays: Mapping[str, float],
    settings: Settings,
) -> PointVelocity:
    """Velocities as measured; or from positions, or from an accelerometer.

    Args:
        recording: of any sensors.
        x_WB: attitude of the base at every row.
        delays: by sensor, s.
        settings: of the whole recording.

    Raises:
        InputError: a column has too few samples.
    """
    if recording.has("velocity.x", "velocity.y", "velocity.z"):
        return PointVelocity(_measured(recording, delays["position"]), Origin.MEASURED)
    if recording.has("position.x", "position.y", "position.z"):
        at = recording.t + delays["position"]
        label = f"{recording.source}: position"
        t, r_S = recording.t, recording.vector("position")
        fits = settings.smoothers("position", lambda: fits_of(t, r_S, name=label))
        rate = smooth_rates(t, r_S, at, label, fits).rate
        return PointVelocity(tuple(rate.T), Origin.SMOOTHED_POSITIONS)
    for sensor, how in (
        ("accelerometer", Origin.INTEGRATED_ACCELEROMETER),
        ("velocity_increment", Origin.SUMMED_INCREMENTS),
    ):
        if recording.has(*(f"{sensor}.{k}" for k in "xyz")):
            return _felt(recording, np.column_stack(x_WB), sensor, how)
    return PointVelocity((), Origin.MISSING)


def _measured(recording: Recording, late: float) -> Columns:
    columns = tuple(recording.column(f"velocity.{k}") for k in "xyz")
    if not late:
        return columns
    t, label = recording.t, f"{recording.source}: velocity"
    return tuple(at_times(t, column, t + late, label) for column in columns)


def _felt(
    recording: Recording, x_WB: Float[np.ndarray, "n 4"], sensor: str, how: Origin
) -> PointVelocity:
    known = np.isfinite(x_WB).all(axis=1)
    t, x, felt = recording.t[known], x_WB[known], recording.vector(sensor)[known]
    if sensor == "accelerometer":
        v = velocity_from_accelerometer(t, x, felt, recording.source)
    else:
        v = velocity_from_increments(x, felt)
    columns = np.full((3, known.size), np.nan)
    columns[:, known] = v.T
    return PointVelocity(tuple(columns), how)
