"""Which sensor an error comes from: all others without noise."""

from collections.abc import Mapping
from typing import Any

COEFFICIENTS = {
    "gyro": (),
    "accelerometer": (),
    "joints": ("position",),
    "wheels": ("position",),
    "attitude": ("angle",),
    "position": ("std",),
}
"""What a sensor's section must give even where it is zero."""


def sensors_alone(sensors: Mapping[str, Any], noisy: str) -> dict[str, Any]:
    """A sensor section with the noise of one sensor only; the others are ideal.

    Args:
        sensors: as in `Robot.sensors`.
        noisy: the sensor that keeps its noise.
    """
    ideal = {
        sensor: dict.fromkeys(COEFFICIENTS[sensor], 0.0)
        for sensor in sensors
        if sensor in COEFFICIENTS
    }
    return {**sensors, **ideal, noisy: sensors[noisy]}
