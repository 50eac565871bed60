"""The sensors of a robot, from the sensor section of its file."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from orbident.errors import InputError
from orbident.files.names import suggestion
from orbident.simulation.encoder import Encoder
from orbident.simulation.inertial import Accelerometer, Gyro
from orbident.simulation.sensor import Sensor
from orbident.simulation.tracking import AttitudeTracker, PositionTracker

KINDS: dict[str, type[Sensor]] = {
    "gyro": Gyro,
    "accelerometer": Accelerometer,
    "joints": Encoder,
    "wheels": Encoder,
    "attitude": AttitudeTracker,
    "position": PositionTracker,
}
"""Trackers by the keys of their sections."""


@dataclass(frozen=True)
class SensorModels:
    """What is measured; None is not."""

    gyro: Gyro | None = None
    accelerometer: Accelerometer | None = None
    joints: Encoder | None = None
    wheels: Encoder | None = None
    attitude: AttitudeTracker | None = None
    position: PositionTracker | None = None


def sensor_models(section: Mapping[str, Any]) -> SensorModels:
    """The sensors that a sensor section declares.

    Args:
        section: as in `Robot.sensors`, SI. By sensor, the fields of its class; `rate`
            beside them is the recording's and no sensor.

    Raises:
        InputError: an unknown sensor or key, a missing key, or a bad value.
    """
    unknown = [key for key in section if key not in {*KINDS, "rate"}]
    if unknown:
        known = suggestion(str(unknown[0]), tuple(KINDS), "keys")
        raise InputError(f"sensors: unknown key {unknown[0]!r}; {known}")
    return SensorModels(
        **{key: _sensor(key, section[key]) for key in KINDS if key in section}
    )


def _sensor(key: str, given: Mapping[str, Any]) -> Any:
    names = tuple(field.name for field in fields(KINDS[key]))
    for name in given:
        if name not in names:
            known = suggestion(str(name), names, "keys")
            raise InputError(f"sensors.{key}: unknown key {name!r}; {known}")
    try:
        return KINDS[key](**given)
    except InputError as error:
        raise InputError(f"sensors.{key}.{error}") from None
    except TypeError:
        raise InputError(
            f"sensors.{key}: a key is missing; give {', '.join(names)}"
        ) from None
