"""A motion as ideal sensors would show it, and as the robot's own would record it.

Accelerations follow from forces, and forces from accelerations, by Eq. 13; that of a
free-floating base follows from conserved momentum.
"""

from collections.abc import Iterator, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.interpolate import CubicHermiteSpline

from orbident.errors import InputError
from orbident.model.core_robot import friction_torques, wheels_of
from orbident.model.equations_of_motion import Motion, motion_with, movable
from orbident.recordings.columns import vector_columns
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.sensor_schema import Sampled, SensorsSpec
from orbident.simulation.flight import FreeFlying
from orbident.simulation.free_floating import FreeFloating, JointMotion
from orbident.simulation.sensor import (
    Reading,
    read_attitude,
    read_increments,
    read_inertial,
    read_position,
    read_scalars,
    sensor_columns,
    stream,
)


def accelerations(
    robot: Robot, motion: FreeFloating, qdd: Float[np.ndarray, "n joints"]
) -> Motion:
    """Solve the equations of motion (Eq. 13), where no force acts on the whole.

    Known are the joints' accelerations and those of held wheels, which are zero; no
    motor drives the free ones. The CM's constant velocity is seen by no sensor here.
    Those of the joints, `qdd`, are at the samples, rad/s^2 or m/s^2. The specific force
    at S is `R_0^T dv_S/dt`: no gravity is felt.
    """
    n, joints = motion.q.shape
    of_base, still = np.zeros((n, 3)), np.zeros_like(motion.qd_rw)
    v = np.hstack([of_base, motion.w, motion.qd, motion.qd_rw])
    known = np.hstack([of_base, of_base, qdd, still])
    free = movable(robot)
    free[6:] = np.append(np.zeros(joints), wheels_of(robot).free)
    return motion_with(robot, motion.q, v, known, free)


Columns = dict[str, Float[np.ndarray, " rows"]]


class Truth(NamedTuple):
    """Noise-free values at the rows of a recording; frames as in the recording's."""

    q: Float[np.ndarray, "rows joints"]
    qd: Float[np.ndarray, "rows joints"]
    q_rw: Float[np.ndarray, "rows wheels"]
    """Wheel angles over full turns, zero at the first row, rad."""
    qd_rw: Float[np.ndarray, "rows wheels"]
    gyro: Float[np.ndarray, "rows 3"]
    accelerometer: Float[np.ndarray, "rows 3"]
    attitude: Float[np.ndarray, "rows 4"]
    position: Float[np.ndarray, "rows 3"]
    velocity: Float[np.ndarray, "rows 3"]
    tau: Float[np.ndarray, "rows joints"] | None = None
    """Torques on what joints move, without friction, N m or N; None if unknown."""

    def shown_torques(self, robot: Robot) -> Float[np.ndarray, "rows joints"] | None:
        """What torque sensors see: also what the robot's friction takes."""
        if self.tau is None:
            return None
        return self.tau + friction_torques(robot, self.qd)

    def columns(self, robot: Robot) -> Columns:
        """All of it, by the names of a recording's columns."""
        columns: Columns = {}
        for k, name in enumerate(robot.joint_names):
            columns[f"joint.{name}.position"] = self.q[:, k]
            columns[f"joint.{name}.velocity"] = self.qd[:, k]
        torques = self.shown_torques(robot)
        if torques is not None:
            names = (f"joint.{name}.torque" for name in robot.joint_names)
            columns |= zip(names, torques.T, strict=True)
        for k, name in enumerate(robot.wheel_names):
            columns[f"wheel.{name}.position"] = self.q_rw[:, k]
            columns[f"wheel.{name}.speed"] = self.qd_rw[:, k]
        for name in ("gyro", "accelerometer", "attitude", "position", "velocity"):
            vector = getattr(self, name)
            columns |= zip(vector_columns(name), vector.T, strict=True)
        return columns


def truth_of(robot: Robot, motion: FreeFloating, trajectory: JointMotion) -> Truth:
    """The noise-free values of every sensor.

    The joints' trajectory is in the robot's order.
    """
    v_dot, f_S, Q = accelerations(robot, motion, trajectory.at(motion.t)[2])
    wheels = 6 + len(robot.joints)
    speeds = CubicHermiteSpline(motion.t, motion.qd_rw, v_dot[:, wheels:])
    return _truth(motion, speeds.antiderivative()(motion.t), f_S, Q[:, 6:wheels])


def truth_of_flight(flight: FreeFlying) -> Truth:
    """The noise-free values of every sensor in free flight.

    Wheels turn on from wherever they were; their angles count from here.
    """
    return _truth(flight, flight.q_rw - flight.q_rw[0], flight.f_S, flight.tau)


def _truth(
    motion: FreeFloating | FreeFlying,
    q_rw: Float[np.ndarray, "rows wheels"],
    f_S: Float[np.ndarray, "rows 3"],
    tau: Float[np.ndarray, "rows joints"],
) -> Truth:
    return Truth(
        q=motion.q,
        qd=motion.qd,
        q_rw=q_rw,
        qd_rw=motion.qd_rw,
        gyro=motion.w,
        accelerometer=f_S,
        attitude=motion.attitude,
        position=motion.r_S,
        velocity=motion.v_S,
        tau=tau,
    )


def measure_truth(
    robot: Robot,
    t: Float[np.ndarray, " rows"],
    true: Truth,
    seed: int = 0,
    truth: bool = False,
) -> Recording:
    """Record a motion with the sensors of the robot's file.

    A sensor that the file does not declare has no columns, but joint positions are
    always there, exact where there are no encoders. Rates of joints and speeds of
    wheels are there where the file declares a tachometer. Nothing shows passive joints.
    Every sensor draws from a stream of its own, so that none changes another's noise.
    The rows are at the times `t`, s, evenly spaced. With `truth` the noise-free
    `truth.*` columns are there too.

    Raises:
        InputError: a sensor's parameters are not usable, its rate does not fit the
            rows, the rows are not evenly spaced, or the seed is no whole number.
    """
    columns = {}
    if robot.sensors.joints is None:
        columns = {
            f"joint.{name}.position": q
            for name, q in zip(robot.joint_names, true.q.T, strict=True)
            if name not in robot.passive
        }
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
        """The name of the stream of random numbers: beside an encoder, one's own."""
        rate = self.components[0] in {"velocity", "speed", "torque", "current"}
        return f"{self.name}.{self.components[0]}" if rate else self.name


def _channels(robot: Robot, true: Truth) -> Iterator[Channel]:
    sensors = robot.sensors
    at = [k for k, x in enumerate(robot.joint_names) if x not in robot.passive]
    names = [robot.joint_names[k] for k in at]
    for key, encoder, owners, what, q, qd in (
        ("joints", sensors.joints, names, "velocity", true.q[:, at], true.qd[:, at]),
        ("wheels", sensors.wheels, robot.wheel_names, "speed", true.q_rw, true.qd_rw),
    ):
        if encoder is None:
            continue
        for k, owner in enumerate(owners):
            name = f"{key.removesuffix('s')}.{owner}"
            # Joint positions are always there.
            if key == "joints" or encoder.white_noise is not None:
                noise = encoder.white_noise or 0.0, encoder.resolution or 0.0
                read = partial(read_scalars, *noise)
                yield Channel(key, encoder, name, ("position",), q[:, [k]], read)
            if encoder.tachometer is not None:
                read = partial(read_scalars, encoder.tachometer, 0.0)
                yield Channel(key, encoder, name, (what,), qd[:, [k]], read)
    torques, seen = sensors.torques, true.shown_torques(robot)
    if torques is not None and seen is not None:
        for k, name in zip(at, names, strict=True):
            constant = robot.torque_constants.get(name)
            # A joint with a torque constant shows its motor's current.
            what, unit = ("torque", 1.0) if constant is None else ("current", constant)
            joint, shown = f"joint.{name}", seen[:, [k]] / unit
            read = partial(read_scalars, torques.white_noise / unit, 0.0)
            yield Channel("torques", torques, joint, (what,), shown, read)
    yield from _of_base(sensors, true)


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
