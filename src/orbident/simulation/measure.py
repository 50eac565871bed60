"""A motion as the sensors of a robot would record it.

The sensors of a robot, from the sensor section of its file.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.files.names import suggestion
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.simulation.free_floating import FreeFloating, JointMotion
from orbident.simulation.inertial import Accelerometer, Gyro
from orbident.simulation.noise_processes import stream
from orbident.simulation.sensor import Reading, Sensor
from orbident.simulation.tracking import AttitudeTracker, Encoder, PositionTracker
from orbident.simulation.truth import Truth, truth_of
from orbident.trajectories.trajectory import Trajectory

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


def measure(
    robot: Robot,
    motion: FreeFloating,
    trajectory: JointMotion,
    seed: int = 0,
    truth: bool = False,
) -> Recording:
    """Record a free-floating motion with the sensors of the robot's file.

    A sensor that the file does not declare has no columns, but joint positions are
    always there, exact where there are no encoders. Rates of joints and speeds of
    wheels are there where the file declares a tachometer. Every sensor draws from a
    stream of its own, so that none changes another's noise.

    Args:
        robot: with its nominal inertia and its sensors.
        motion: the free-floating motion, at evenly spaced times: the rows.
        trajectory: of the joints, that the motion was made with.
        seed: of all random numbers.
        truth: whether to add the noise-free `truth.*` columns.

    Raises:
        InputError: a sensor's parameters are not usable, its rate does not fit the
            rows, the rows are not evenly spaced, or the seed is no whole number.
    """
    if isinstance(trajectory, Trajectory):
        trajectory = trajectory.for_robot(robot)
    true = truth_of(robot, motion, trajectory)
    return measure_truth(robot, motion.t, true, seed, truth)


def measure_truth(
    robot: Robot,
    t: Float[np.ndarray, " rows"],
    true: Truth,
    seed: int = 0,
    truth: bool = False,
) -> Recording:
    """Record what is true of any motion, as `measure` does.

    Args:
        robot: with its sensors.
        t: evenly spaced times, s: the rows.
        true: at these times.
        seed: of all random numbers.
        truth: whether to add the noise-free `truth.*` columns.

    Raises:
        InputError: as `measure`.
    """
    sensors = sensor_models(robot.sensors)
    columns = {}
    for channel in _channels(robot, sensors, true):
        sensor = getattr(sensors, channel.key)
        if sensor is not None:
            values = _measured(channel, sensor, t, seed)
        elif channel.key == "joints":
            values = channel.true
        else:
            continue
        for k, component in enumerate(channel.components):
            columns[f"{channel.name}.{component}"] = values[:, k]
    if truth:
        columns |= {
            f"truth.{name}": column for name, column in true.columns(robot).items()
        }
    return Recording(t, columns, source=f"simulation of {robot.name}")


class Channel(NamedTuple):
    """What one sensor, or one of several encoders, is there to see."""

    key: str
    """Name of the section of the sensor."""
    name: str
    """What the columns' names have before the dot."""
    components: Sequence[str]
    """What the columns' names have after the dot."""
    true: Float[np.ndarray, "rows true"]
    """The noise-free values."""
    read: Reading | None = None
    """Instead of the sensor's own."""

    @property
    def stream(self) -> str:
        """The name of the stream of random numbers: a tachometer has one of its own."""
        rate = self.components[0] in {"velocity", "speed"}
        return f"{self.name}.{self.components[0]}" if rate else self.name


def _channels(robot: Robot, sensors: SensorModels, true: Truth) -> Iterator[Channel]:
    joints, wheels = sensors.joints, sensors.wheels
    for k, name in enumerate(robot.joint_names):
        joint = f"joint.{name}"
        yield Channel("joints", joint, ("position",), true.q[:, [k]])
        if joints is not None and joints.tachometer is not None:
            rate = true.qd[:, [k]]
            yield Channel("joints", joint, ("velocity",), rate, joints.read_rates)
    for k, name in enumerate(robot.wheel_names):
        wheel = f"wheel.{name}"
        if wheels is not None and wheels.position is not None:
            yield Channel("wheels", wheel, ("position",), true.q_rw[:, [k]])
        if wheels is not None and wheels.tachometer is not None:
            speed = true.qd_rw[:, [k]]
            yield Channel("wheels", wheel, ("speed",), speed, wheels.read_rates)
    yield Channel("gyro", "gyro", "xyz", true.gyro)
    if sensors.accelerometer is not None and sensors.accelerometer.increments:
        pose = np.hstack([true.attitude, true.velocity])
        read = sensors.accelerometer.read_increments
        yield Channel("accelerometer", "velocity_increment", "xyz", pose, read)
    else:
        yield Channel("accelerometer", "accelerometer", "xyz", true.accelerometer)
    yield Channel("attitude", "attitude", "xyzw", true.attitude)
    yield Channel("position", "position", "xyz", true.position)


def _measured(
    channel: Channel, sensor: Sensor, t: Float[np.ndarray, " rows"], seed: int
) -> Float[np.ndarray, "rows axes"]:
    """A sensor's samples; what is wrong with it is said with its place in the file."""
    random = stream(seed, channel.stream)
    try:
        return sensor.sample(t, channel.true, random, channel.read)
    except InputError as error:
        raise InputError(f"sensors.{channel.key}: {error}") from None
