"""What the sensors of a recording show, and the same changed."""

import numpy as np
from jaxtyping import Bool, Float
from scipy.spatial.transform import Rotation

from orbident.estimation.output_error.sensors import COMPONENTS
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot


def shown_by(
    robot: Robot, recording: Recording
) -> dict[str, Float[np.ndarray, "n axes"]]:
    """What each joint and each sensor of the base shows, smooth where the motion is."""
    tables = {
        f"joint.{name}": recording.column(f"joint.{name}.position")[:, None]
        for name in robot.joint_names
        if recording.has(f"joint.{name}.position")
    }
    for sensor, parts in COMPONENTS.items():
        if recording.has(*(f"{sensor}.{part}" for part in parts)):
            tables[sensor] = recording.vector(sensor, parts)
    if "attitude" in tables:
        tables["attitude"] = _continuous(tables["attitude"])
    return tables


def _continuous(x: Float[np.ndarray, "n 4"]) -> Float[np.ndarray, "n 4"]:
    """`x` and `-x` are one attitude: that nearer to the one before."""
    seen = np.flatnonzero(np.isfinite(x).all(axis=1))
    along = np.sum(x[seen[1:]] * x[seen[:-1]], axis=1)
    x[seen[1:]] *= np.cumprod(np.where(along < 0, -1.0, 1.0))[:, None]
    return x


def of_vector(
    sensor: str, x: Float[np.ndarray, "n axes"]
) -> dict[str, Float[np.ndarray, " n"]]:
    """The columns of a vector or quaternion."""
    names = "xyzw"[: x.shape[1]]
    parts = zip(names, np.ascontiguousarray(x.T), strict=True)
    return {f"{sensor}.{k}": part for k, part in parts}


def without(
    recording: Recording, sensor: str, rows: Bool[np.ndarray, " n"]
) -> Recording:
    """Without these samples of a sensor, or of a joint."""
    left_out = {
        name: np.where(rows, np.nan, column)
        for name, column in recording.columns.items()
        if name.startswith(f"{sensor}.")
    }
    return recording.with_columns(left_out)


def less(
    recording: Recording, sensor: str, error: Float[np.ndarray, "n axes"]
) -> Recording:
    """What a sensor would show without an error.

    Args:
        recording: with the sensor.
        sensor: `joint.<name>`, a vector, or the attitude.
        error: of an attitude the turn of the sensor in its own axes, rad.
    """
    if sensor.startswith("joint."):
        name = f"{sensor}.position"
        return recording.with_columns({name: recording.columns[name] - error[:, 0]})
    if sensor != "attitude":
        right = recording.vector(sensor) - error
        return recording.with_columns(of_vector(sensor, right))
    x = recording.vector(sensor, "xyzw").copy()
    seen = np.isfinite(x).all(axis=1)
    right = Rotation.from_quat(x[seen]) * Rotation.from_rotvec(-error[seen])
    x[seen] = right.as_quat()
    return recording.with_columns(of_vector(sensor, x))
