"""The velocity of S at the rows of a recording."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.preprocessing.histories import MEASURED, Columns
from orbident.preprocessing.rates import at_times
from orbident.preprocessing.settings import Settings
from orbident.preprocessing.smoothing import fits_of, smooth_rates
from orbident.preprocessing.velocity import (
    velocity_from_accelerometer,
    velocity_from_increments,
)
from orbident.recordings.recording import Recording

SMOOTHED = "derived: smoothed positions"
FELT = "derived: integrated accelerometer, its bias estimated"
COUNTED = "derived: summed velocity increments, their bias estimated"
BIASED = {FELT, COUNTED}
"""In these the bias of an accelerometer shows."""
MISSING = "missing"


class PointVelocity(NamedTuple):
    """Columns; empty where they cannot be had."""

    v_S: Columns
    """Inertial axes, m/s; but for a constant where it is derived from forces."""
    origin: str


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
        return PointVelocity(_measured(recording, delays["position"]), MEASURED)
    if recording.has("position.x", "position.y", "position.z"):
        at = recording.t + delays["position"]
        label = f"{recording.source}: position"
        t, r_S = recording.t, recording.vector("position")
        fits = settings.smoothers("position", lambda: fits_of(t, r_S, name=label))
        rate = smooth_rates(t, r_S, at, label, fits).rate
        return PointVelocity(tuple(rate.T), SMOOTHED)
    for sensor, how in (("accelerometer", FELT), ("velocity_increment", COUNTED)):
        if recording.has(*(f"{sensor}.{k}" for k in "xyz")):
            return _felt(recording, np.column_stack(x_WB), sensor, how)
    return PointVelocity((), MISSING)


def _measured(recording: Recording, late: float) -> Columns:
    columns = tuple(recording.column(f"velocity.{k}") for k in "xyz")
    if not late:
        return columns
    t, label = recording.t, f"{recording.source}: velocity"
    return tuple(at_times(t, column, t + late, label) for column in columns)


def _felt(
    recording: Recording, x_WB: Float[np.ndarray, "n 4"], sensor: str, how: str
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
