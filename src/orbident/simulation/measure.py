"""A motion as the sensors of a robot would record it."""

from collections.abc import Iterator, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.sensor_schema import EncoderSpec, Sampled, SensorsSpec
from orbident.simulation.free_floating import FreeFloating, JointMotion
from orbident.simulation.sensor import (
    Reading,
    read_angles,
    read_attitude,
    read_increments,
    read_inertial,
    read_position,
    read_rates,
    sensor_columns,
    stream,
)
from orbident.simulation.truth import Truth, truth_of
from orbident.trajectories.trajectory import Trajectory


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
    columns = {}
    if robot.sensors.joints is None:
        names = (f"joint.{name}.position" for name in robot.joint_names)
        columns = dict(zip(names, true.q.T, strict=True))
    for channel in _channels(robot, true):
        values = _measured(channel, t, seed)
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
    sensor: Sampled
    name: str
    """What the columns' names have before the dot."""
    components: Sequence[str]
    """What the columns' names have after the dot."""
    true: Float[np.ndarray, "rows true"]
    """The noise-free values."""
    read: Reading

    @property
    def stream(self) -> str:
        """The name of the stream of random numbers: a tachometer has one of its own."""
        rate = self.components[0] in {"velocity", "speed"}
        return f"{self.name}.{self.components[0]}" if rate else self.name


def _channels(robot: Robot, true: Truth) -> Iterator[Channel]:
    joints, wheels = robot.sensors.joints, robot.sensors.wheels
    if joints is not None:
        for k, name in enumerate(robot.joint_names):
            pair = true.q[:, [k]], true.qd[:, [k]]
            yield from _encoder("joints", joints, f"joint.{name}", "velocity", *pair)
    if wheels is not None:
        for k, name in enumerate(robot.wheel_names):
            pair = true.q_rw[:, [k]], true.qd_rw[:, [k]]
            yield from _encoder("wheels", wheels, f"wheel.{name}", "speed", *pair)
    yield from _of_base(robot.sensors, true)


def _encoder(
    key: str,
    sensor: EncoderSpec,
    name: str,
    rate: str,
    q: Float[np.ndarray, "rows 1"],
    qd: Float[np.ndarray, "rows 1"],
) -> Iterator[Channel]:
    # Joint positions are always there.
    if key == "joints" or sensor.white_noise is not None:
        read = partial(read_angles, sensor)
        yield Channel(key, sensor, name, ("position",), q, read)
    if sensor.tachometer is not None:
        yield Channel(key, sensor, name, (rate,), qd, partial(read_rates, sensor))


def _of_base(sensors: SensorsSpec, true: Truth) -> Iterator[Channel]:
    if (gyro := sensors.gyro) is not None:
        read = partial(read_inertial, gyro)
        yield Channel("gyro", gyro, "gyro", "xyz", true.gyro, read)
    if (felt := sensors.accelerometer) is not None:
        name, seen, read = "accelerometer", true.accelerometer, read_inertial
        if felt.increments:
            name, read = "velocity_increment", read_increments
            seen = np.hstack([true.attitude, true.velocity])
        yield Channel("accelerometer", felt, name, "xyz", seen, partial(read, felt))
    if (attitude := sensors.attitude) is not None:
        read = partial(read_attitude, attitude)
        yield Channel("attitude", attitude, "attitude", "xyzw", true.attitude, read)
    if (position := sensors.position) is not None:
        read = partial(read_position, position)
        yield Channel("position", position, "position", "xyz", true.position, read)


def _measured(
    channel: Channel, t: Float[np.ndarray, " rows"], seed: int
) -> Float[np.ndarray, "rows axes"]:
    """A sensor's samples; what is wrong with it is said with its place in the file."""
    random = stream(seed, channel.stream)
    try:
        return sensor_columns(channel.sensor, t, channel.true, random, channel.read)
    except InputError as error:
        raise InputError(f"sensors.{channel.key}: {error}") from None
