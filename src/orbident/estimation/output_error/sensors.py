"""What every sensor showed, at its own times, and how far it is to be trusted."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.simulation.inertial import CORRELATION_TIME
from orbident.simulation.noise import bias_walk

COMPONENTS = {
    "gyro": "xyz",
    "accelerometer": "xyz",
    "attitude": "xyzw",
    "position": "xyz",
    "velocity": "xyz",
}
"""Of the base's sensors; encoders are beside them."""

INCREMENTS = tuple(f"velocity_increment.{k}" for k in "xyz")

CLOCKS = {"velocity": "position"}
"""Sensors that share another's clock."""

INERTIAL = {"gyro": "angle_random_walk", "accelerometer": "velocity_random_walk"}
POINTS = {"attitude": "angle", "position": "std"}

TOGETHER = 1e-6
"""s: samples this close are of one time; clocks and their latencies are rounded."""

LEAST = 1e-9
"""Of a signal's size, or rad: the least noise of a sensor."""

NORMAL = 1.4826
"""Std over median absolute value, of Gaussian noise."""


@dataclass(frozen=True)
class Sensed:
    """One sensor's samples; NaN at times without one."""

    values: Float[np.ndarray, "rows axes"]
    std: float
    """Of the white noise of a sample, SI."""
    least: float
    """Smaller noise is the integration's and the splines'."""
    declared: bool
    """Whether that is from the robot file."""
    drift: float = 0.0
    """Random walk of the bias, per square root of a second."""


@dataclass(frozen=True)
class Sensors:
    """All sensors on common times."""

    t: Float[np.ndarray, " rows"]
    by_name: Mapping[str, Sensed]


def sensors_of(
    robot: Robot, recording: Recording, behind: Mapping[str, float]
) -> Sensors:
    """The sensors of a recording, at the times at which they saw the world.

    Args:
        robot: with the noise of its sensors, where that is known.
        recording: of any of them.
        behind: by sensor, by how much its times are behind, s.
    """
    tables = {
        sensor: recording.vector(sensor, components)
        for sensor, components in COMPONENTS.items()
        if recording.has(*(f"{sensor}.{k}" for k in components))
    }
    joints = robot.joint_names
    if joints and not any(recording.has(f"joint.{name}.velocity") for name in joints):
        encoders = [recording.column(f"joint.{name}.position") for name in joints]
        tables["joints"] = np.column_stack(encoders)
    times, samples = {}, {}
    for name, table in tables.items():
        seen = np.isfinite(table).all(axis=1)
        if seen.any():
            late = behind[CLOCKS.get(name, name)]
            times[name], samples[name] = recording.t[seen] - late, table[seen]
    if recording.has(*INCREMENTS) and "gyro" in samples:
        felt = _felt(recording, times["gyro"], samples["gyro"], behind["accelerometer"])
        times["accelerometer"], samples["accelerometer"] = felt
    t = np.unique(np.concatenate(list(times.values())))
    t = t[np.diff(t, prepend=-np.inf) > TOGETHER]
    return Sensors(
        t, {name: _sensed(robot, name, t, times[name], samples[name]) for name in times}
    )


def _felt(
    recording: Recording,
    gyro_t: Float[np.ndarray, " m"],
    gyro: Float[np.ndarray, "m 3"],
    late: float,
) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, "n 3"]]:
    """Mean specific forces, half-way through each velocity increment.

    The increment is in the base's axes at its start, half of its turn ago.
    """
    dv = recording.vector("velocity_increment")
    seen = np.isfinite(dv).all(axis=1)
    t, dv = recording.t[seen] - late, dv[seen]
    dt = np.diff(t)[:, None]
    middle = (t[:-1] + t[1:]) / 2
    w = np.column_stack([np.interp(middle, gyro_t, axis) for axis in gyro.T])
    half = Rotation.from_rotvec(-w * dt / 2)
    return middle, half.apply(dv[1:] / dt)


def _sensed(
    robot: Robot,
    name: str,
    t: Float[np.ndarray, " rows"],
    at: Float[np.ndarray, " samples"],
    samples: Float[np.ndarray, "samples axes"],
) -> Sensed:
    values = np.full((t.size, samples.shape[1]), np.nan)
    values[np.searchsorted(t, at, side="right") - 1] = samples
    section = robot.sensors.get(name) or {}
    std, drift = _declared(name, section, at)
    declared = bool(std > 0)
    if not declared:
        std = scatter(samples)
    if name == "attitude":
        least = LEAST
    else:
        least = LEAST * float(np.sqrt(np.mean(samples**2)))
    least = max(least, 1e-15)
    return Sensed(values, max(std, least), least, declared, drift)


def _declared(
    name: str, section: Mapping[str, Any], at: Float[np.ndarray, " samples"]
) -> tuple[float, float]:
    """Std of a sample and random walk of the bias; zero where not declared."""
    if name in INERTIAL:
        dt = float(np.median(np.diff(at))) if at.size > 1 else 1.0
        tau = section.get("correlation_time", CORRELATION_TIME)
        drift = bias_walk(section.get("bias_instability", 0.0), tau)
        return float(section.get(INERTIAL[name], 0.0) / np.sqrt(dt)), drift
    if name in POINTS:
        return section.get(POINTS[name], 0.0), 0.0
    if name == "joints":
        count = section.get("resolution", 0.0) / np.sqrt(12)
        return float(np.hypot(section.get("position", 0.0), count)), 0.0
    return 0.0, 0.0


def scatter(samples: Float[np.ndarray, "samples axes"]) -> float:
    """Std of white noise, from fourth differences: these have 70 times its variance.

    That of the noisiest axis: in the plane some show nothing.
    """
    if len(samples) < 5:
        return 0.0
    bends = np.median(np.abs(np.diff(samples, n=4, axis=0)), axis=0)
    return float(NORMAL * bends.max() / np.sqrt(70))
