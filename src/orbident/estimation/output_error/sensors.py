"""What every sensor showed, at its own times, and how far it is to be trusted.

The core takes noise of attitude and position that lasts: its parts at each boundary
are unknowns, and inside an interval samples are whitened by their filter
(`lasting_noise.hpp`), so that intervals stay coupled by boundaries alone.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from orbident import _core
from orbident.environment.agents import WALKS
from orbident.files.bounds import TOGETHER
from orbident.gaussian import noisiest_std
from orbident.model.kinematics import inertia_at
from orbident.preprocessing.base_motion import same_sign
from orbident.preprocessing.rate_noise import RateNoise, rate_noise
from orbident.preprocessing.rates import through_gaps
from orbident.preprocessing.samples import Samples
from orbident.recordings.columns import VECTORS
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.sensor_schema import WHITE, Coloured

COMPONENTS = {
    name: VECTORS[name][0]
    for name in ("gyro", "accelerometer", "attitude", "position", "velocity")
}
"""Components of the base's sensors; encoders are not among them."""

TORQUES = "torques"
"""The sensors of torques at joints."""

CLOCKS = {"velocity": "position"}
"""Sensors that share another's clock."""

LEAST = 3e-8
"""Least noise of a sensor, over its signal's size or in rad. Splines and integration
err by some 1e-9, alike from sample to sample: some thousand samples of so much noise
are as far off together."""


def torque_column(joint: str) -> str:
    """The column of a recording that has it."""
    return f"joint.{joint}.torque"


def joints_with_torques(robot: Robot, recording: Recording) -> list[str]:
    """The joints whose torque was recorded."""
    shown = recording.columns
    return [name for name in robot.joint_names if torque_column(name) in shown]


@dataclass(frozen=True)
class Sensed:
    """One sensor's samples; NaN at times without one."""

    values: Float[np.ndarray, "rows axes"]
    std: float
    """Standard deviation of a sample's noise: white, and what tachometers add, SI."""
    least: float
    """Smaller noise is the integration's and the splines'."""
    declared: bool
    """Whether that is from the robot file."""
    drift: float = 0.0
    """Random walk of the bias, per square root of a second."""
    coloured: Coloured = WHITE
    """What lasts of a tracker's noise."""


@dataclass(frozen=True)
class Sensors:
    """All sensors on common times."""

    t: Float[np.ndarray, " rows"]
    by_name: Mapping[str, Sensed]


def sensors_of(
    robot: Robot,
    recording: Recording,
    behind: Mapping[str, float],
    speeds: Sequence[RateNoise] = (),
) -> Sensors:
    """The sensors of a recording, at the times at which they saw the world.

    Args:
        robot: with the noise of its sensors, where that is known.
        recording: of any of them.
        behind: by sensor, by how much its times are behind, s.
        speeds: noise of those of the wheels.
    """
    shown = _shown(robot, recording, behind)
    t = _times_of(shown)
    sensors = {name: _sensed(robot, name, t, *each) for name, each in shown.items()}
    if "gyro" in sensors and sensors["gyro"].declared:
        std = float(np.hypot(sensors["gyro"].std, rate_noise(robot, speeds)))
        sensors["gyro"] = replace(sensors["gyro"], std=std)
    return Sensors(t, sensors)


def sensors_like(
    sensors: Sensors, robot: Robot, recording: Recording, behind: Mapping[str, float]
) -> Sensors:
    """Those of a recording that differs little: their noise is the same.

    Args:
        sensors: of the other recording.
        robot: as `sensors_of` has it.
        recording: with samples of the same sensors.
        behind: as `sensors_of` has it.
    """
    shown = _shown(robot, recording, behind)
    t = _times_of(shown)
    every = {
        name: replace(sensors.by_name[name], values=_values(t, *each))
        for name, each in shown.items()
    }
    return Sensors(t, every)


class _Shown(NamedTuple):
    at: Float[np.ndarray, " samples"]
    """When the sensor saw the world, s."""
    samples: Float[np.ndarray, "samples axes"]


def _times_of(shown: Mapping[str, _Shown]) -> Float[np.ndarray, " rows"]:
    """All times at which a sensor has a sample, s."""
    t = np.unique(np.concatenate([each.at for each in shown.values()]))
    return through_gaps(t[np.diff(t, prepend=-np.inf) > TOGETHER])


def _shown(
    robot: Robot, recording: Recording, behind: Mapping[str, float]
) -> dict[str, _Shown]:
    """The samples of each sensor, and when it saw the world."""
    tables = {
        sensor: recording.vector(sensor)
        for sensor in COMPONENTS
        if recording.has_vector(sensor)
    }
    sums = "velocity_increment"
    increments = recording.vector(sums) if recording.has_vector(sums) else None
    joints = [name for name in robot.joint_names if name not in robot.passive]
    encoders = robot.sensors.joints
    exact = any(recording.has(f"joint.{name}.velocity") for name in joints) and not (
        encoders and encoders.tachometer
    )
    if joints and not exact:
        angles = [recording.column(f"joint.{n}.position") for n in robot.joint_names]
        tables["joints"] = np.column_stack(angles)
    driven = joints_with_torques(robot, recording)
    if driven:
        tables[TORQUES] = torques = np.zeros((recording.t.size, len(robot.joints)))
        for name in driven:
            which = robot.joint_names.index(name)
            torques[:, which] = recording.columns[torque_column(name)]
    shown = {}
    for name in list(tables):
        table = tables.pop(name)
        seen = np.asarray(np.isfinite(table).all(axis=1))
        if seen.any():
            at = some_of(recording.t, seen) - behind[CLOCKS.get(name, name)]
            samples = some_of(table, seen)
            shown[name] = _Shown(
                at, same_sign(samples) if name == "attitude" else samples
            )
    if increments is not None and "gyro" in shown:
        t = recording.t - behind["accelerometer"]
        shown["accelerometer"] = _Shown(*_felt(t, increments, *shown["gyro"]))
    return shown


def _felt(
    t: Float[np.ndarray, " rows"],
    dv: Float[np.ndarray, "rows 3"],
    gyro_t: Float[np.ndarray, " m"],
    gyro: Float[np.ndarray, "m 3"],
) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, "n 3"]]:
    """Mean specific forces, half-way through each velocity increment.

    The increment is in the base's axes at its start, half of its turn ago.
    """
    seen = np.isfinite(dv).all(axis=1)
    t, dv = t[seen], dv[seen]
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
    sensor = robot.sensors.of(name)
    std = sensor.white_std(float(np.median(np.diff(at))) if at.size > 1 else 1.0)
    declared = std > 0
    if not declared:
        std = noisiest_std(samples)
    size = 1.0 if name == "attitude" else float(np.sqrt(np.mean(samples**2)))
    least = max(LEAST * size, between(at, samples), 1e-15)
    std = max(std, least)
    values = _values(t, at, samples)
    return Sensed(values, std, least, declared, sensor.bias_walk, sensor.coloured)


def _values(
    t: Float[np.ndarray, " rows"],
    at: Float[np.ndarray, " samples"],
    samples: Float[np.ndarray, "samples axes"],
) -> Float[np.ndarray, "rows axes"]:
    """One sensor's samples at the times of all sensors; NaN where it has none."""
    rows = np.searchsorted(t, at, side="right") - 1
    if np.array_equal(rows, np.arange(t.size)):
        return samples
    values = np.full((t.size, samples.shape[1]), np.nan)
    values[rows] = samples
    return values


def between(
    t: Float[np.ndarray, " samples"], x: Float[np.ndarray, "samples axes"]
) -> float:
    """How far off a cubic spline through samples is between them, root mean square.

    That of a spline through every other sample is known at those left out; it falls
    with the fourth power of the step.
    """
    if len(t) < 8 or not x.size:
        return 0.0
    left_out = slice(1, len(t) - 1, 2)
    off = CubicSpline(t[::2], x[::2])(t[left_out]) - x[left_out]
    return float(np.sqrt(np.mean(off**2)) / 2**4)


def some_of(
    x: Float[np.ndarray, " rows *axes"], which: Bool[np.ndarray, " rows"]
) -> Float[np.ndarray, " some *axes"]:
    """Some rows, all at hand in one piece; not copied where they lie together."""
    rows = np.flatnonzero(which)
    if rows.size and rows[-1] - rows[0] + 1 == rows.size:
        return np.ascontiguousarray(x[rows[0] : rows[-1] + 1])
    return x[rows]


TRACKERS = ("attitude", "position")
"""The sensors whose noise may last, in the core's order."""

MARKOV_STD, CORRELATION_TIME, RANDOM_WALK, RATE_WALK = range(4)

Lasting = Float[np.ndarray, "2 3 4"]
"""The four parameters above by tracker and axis; zero where the noise is white."""

Tables = Mapping[str, Float[np.ndarray, "rows axes"]]


def lasting_noise(
    robot: Robot, sensors: Sensors, walks: Mapping[str, float]
) -> Lasting:
    """What lasts of the noise of the axes that count, and rates that walk."""
    lasting = np.zeros((2, 3, 4))
    for k, (name, axes) in enumerate(zip(TRACKERS, robot.conserved_axes, strict=True)):
        sensed = sensors.by_name.get(name)
        if sensed is not None:
            lasting[k, axes, :RATE_WALK] = np.transpose(sensed.coloured)[list(axes)]
            lasting[k, axes, RATE_WALK] = walks.get(WALKS[k], 0.0)
    return lasting


LAG = 1.0
"""s: in so long rates change by more than the noise of what they were derived from."""

POSE = {"attitude", "position", "joints"}
"""Where no rate of the base is among the sensors, a momentum that walks at random is
noise of the pose whose rate walks, as far as the robot's inertia does not change, and
nothing on it swings."""


def walks_of_rates(
    robot: Robot, sensors: Sensors, samples: Samples
) -> dict[str, float]:
    """Walks of a planar robot's momentum that only its pose shows.

    Returns:
        By group, torque before force: the density of the rate of turn, or of the
        velocity, in rad/s^2/sqrt(Hz) or m/s^2/sqrt(Hz); as it is declared, or so much
        that without any thrust it would have changed the rate as it changed.
    """
    if robot.motion != "planar" or not {*sensors.by_name} <= POSE or robot.passive:
        return {}
    lag, found = round(LAG / float(np.median(np.diff(samples.t)))) or 1, {}
    moved, per_rate = (samples.w, samples.v_S), inertia_of_walks(robot)
    for group, rate, q in zip(WALKS, moved, robot.momentum_walk, strict=True):
        if group in robot.said_to_act and rate:
            changes = np.array([x[lag:] - x[:-lag] for x in rate])
            passed = np.mean(samples.t[lag:] - samples.t[:-lag])
            most = np.sqrt(np.nanmean(np.sum(changes**2, axis=0)) / passed)
            found[group] = q / per_rate[group] or float(most)
    return found


def inertia_of_walks(robot: Robot) -> dict[str, float]:
    """What a planar robot's rates times make its momenta, by CAD: kg m^2, and kg."""
    D = inertia_at(robot, np.zeros(len(robot.joints))).D
    return dict(zip(WALKS, (float(D[2, 2]), robot.mass), strict=True))


def lasting_parts(lasting: Lasting) -> Bool[np.ndarray, "2 3 4"]:
    """Which parts there are; what walks by its rate has two, its rate the last."""
    return lasting[..., [MARKOV_STD, RANDOM_WALK, RATE_WALK, RATE_WALK]] > 0


def parts_of_boundaries(lasting: Lasting) -> Bool[np.ndarray, "2 3 4"]:
    """Those that are unknowns of boundaries: an attitude has what its rate gave it."""
    parts = lasting_parts(lasting)
    parts[0, :, RATE_WALK - 1] = False
    return parts


def first_lasting(
    lasting: Lasting, dt: float, inertia: float
) -> Float[np.ndarray, " parts"]:
    """Standard deviations of the parts at the first row, in the core's order.

    Of an attitude whose rate walks it is that of the momentum, with this inertia.

    A walk is zero at the first sample; here it begins one sample earlier.
    """
    walks = lasting[..., [RANDOM_WALK, RATE_WALK, RATE_WALK]]
    walks[0, 2, 2] *= inertia
    since = np.sqrt([dt, dt**3 / 3, dt])
    std = np.concatenate([lasting[..., [MARKOV_STD]], walks * since], axis=-1)
    return std[parts_of_boundaries(lasting)]


def at_level(lasting: Lasting, assumed: Tables, weights: Tables) -> Lasting:
    """The lasting noise, at the level of noise that the weights of sensors have.

    All parts of a sensor's noise are as many times as large as assumed as the white
    one; the largest weight is that of samples which are no outliers.
    """
    scaled = lasting.copy()
    for k, name in enumerate(TRACKERS):
        if lasting[k].any():
            level = float(assumed[name].max() / weights[name].max())
            scaled[k][:, [MARKOV_STD, RANDOM_WALK]] *= level
    return scaled


def innovated(
    t: Float[np.ndarray, " rows"],
    lasting: Lasting,
    residuals: Tables,
    plain: Tables,
    used: Tables,
) -> dict[str, Float[np.ndarray, "rows axes"]]:
    """Residuals of all sensors over their noise, white where noise lasts too.

    Those of a tracker whose noise lasts become innovations over the whole recording.

    Args:
        t: of the rows, s.
        lasting: at the level of the weights.
        residuals: over the white noise.
        plain: 1 over the white noise's deviation; zero without a sample.
        used: the same, less for outliers: these say less of what lasts.
    """
    found = dict(residuals)
    for k, name in enumerate(TRACKERS):
        if name not in residuals:
            continue
        for axis in np.flatnonzero(lasting[k].any(axis=1)):
            table = found[name] = np.array(found[name])
            seen = plain[name][:, axis] > 0
            weight, counted = (w[name][seen, axis] for w in (plain, used))
            errors = table[seen, axis] / weight
            variance = counted**-2
            v, S = _core.innovations(
                t[seen], errors[:, None], variance, lasting[k, axis]
            )
            # What is not predicted of an outlier counts in full.
            table[seen, axis] = v[:, 0] / np.sqrt(S - variance + weight**-2)
    return found
