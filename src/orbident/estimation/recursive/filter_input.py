"""What the filter takes from a recording: its samples, and the noise of each."""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.estimation.linear_fits import fit
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.recursive.driven_joints import (
    NO_TORQUES,
    DrivenJoints,
    Torques,
    torques_of,
)
from orbident.model.core_robot import wheels_of
from orbident.model.minimal_sets import minimal_sets
from orbident.preprocessing.origins import ENCODED, Origin
from orbident.preprocessing.rate_noise import declared_rate_noise
from orbident.preprocessing.samples import Samples
from orbident.preprocessing.smoothing import Settings
from orbident.preprocessing.stretches import (
    Piece,
    packed_piece,
    rate_scatter,
    smoothed_rate,
    trusted,
)
from orbident.robot.description import Robot
from orbident.robot.sensor_schema import (
    AccelerometerSpec,
    AttitudeSpec,
    EncoderSpec,
    GyroSpec,
    PositionSpec,
    TrackerSpec,
)
from orbident.threads import ahead

MEMORY = 1.0
"""s: a smoothed rate is as wrong as its positions are over such a time."""

LEAST = 1e-9
"""rad/s, and m/s: without noise the weights would be infinite."""

COLOURED = 5.0
"""Neighbours share the error of a smoothed pose: so much noisier they count, that many
samples tell no more than the few that are independent."""

FINE = 0.1
"""An integrated velocity's error from sample to sample that is no random walk, over
what the walk is."""


class Noise(NamedTuple):
    """Standard deviations; SI."""

    gyro: float
    """White noise of a rate sample, rad/s."""
    velocity: float
    """White noise of a velocity sample, m/s."""
    gyro_bias: float = LEAST
    """Deviation of the gyro's bias beforehand, rad/s."""
    gyro_walk: float = 0.0
    """Random walk of the gyro's bias, rad/s/sqrt(s)."""
    integrated: float = 0.0
    """1 where the attitude is the integrated gyro, and drifts with it; else 0."""
    attitude: float = 0.0
    """White noise of an attitude sample, rad."""
    velocity_walk: float = 0.0
    """Random walk of the CM's velocity, or of one integrated from an accelerometer,
    m/s/sqrt(s)."""
    accelerometer_bias: float = LEAST
    """Deviation of the accelerometer's bias beforehand, m/s^2."""
    accelerometer_walk: float = 0.0
    """Random walk of the accelerometer's bias, m/s^2/sqrt(s)."""
    joint_rates: float = 0.0
    """White noise of a joint rate sample, rad/s or m/s."""
    momentum_walk: float = 0.0
    """Random walk of the angular momentum, or of the attitude in which it is seen,
    N m s/sqrt(s)."""
    accelerometer: bool = False
    """Whether the velocity is integrated from one, and its bias an unknown."""
    declared: bool = True
    """Whether the velocity's noise is declared, not what least squares leaves of it."""
    driven: DrivenJoints = NO_TORQUES
    """Joints whose torque is measured."""


def noise_of(robot: Robot, samples: Samples, seen: float = 0.0) -> Noise:
    """As the robot file declares the sensors, where it does.

    Args:
        robot: with its sensors.
        samples: of a recording.
        seen: scatter of the gyro's samples, rad/s, for one that is not declared.

    Raises:
        InputError: the base rate is that of a smoothed attitude of unknown noise.
    """
    dt = float(np.median(np.diff(samples.t)))
    gyro = robot.sensors.gyro or GyroSpec()
    force = robot.sensors.accelerometer or AccelerometerSpec()
    attitude = robot.sensors.attitude or AttitudeSpec(angle=0.0)
    position = robot.sensors.position or PositionSpec(std=0.0)
    joints = robot.sensors.joints or EncoderSpec(position=0.0)
    turns = attitude.coloured.random_walk.max()
    walk = force.white_noise if samples.biased else 0.0
    measured = samples.origins["base_rate"] is not Origin.SMOOTHED_ATTITUDE
    integrated = samples.origins["attitude"] is Origin.INTEGRATED_GYRO
    derived = samples.origins["joint_rates"] & ENCODED
    if not measured and not attitude.white_noise:
        raise InputError(
            f"{robot.name}: sensors: found no noise of the attitude, and the recording "
            "has no gyro; give attitude.angle in the robot file"
        )
    if measured:
        rate = gyro.white_std(dt) or seen
        if any(map(any, samples.speeds)):
            rate = np.hypot(rate, declared_rate_noise(robot))
    else:
        rate = COLOURED * _changing(attitude) / MEMORY
    smoothed = samples.origins["velocity"] is Origin.SMOOTHED_POSITIONS
    velocity = FINE * walk * np.sqrt(dt)
    if smoothed and position.white_noise:
        velocity = COLOURED * _changing(position) / MEMORY
    seen_to_walk = turns * _spin(robot, samples) if turns else 0.0
    return Noise(
        gyro=max(float(rate), LEAST),
        velocity=float(velocity or _left_over(robot, samples)),
        gyro_bias=max(gyro.turn_on_std, LEAST) if measured else LEAST,
        gyro_walk=gyro.bias_walk if measured else 0.0,
        integrated=float(integrated),
        attitude=0.0 if integrated or not measured else _as_white(attitude, dt),
        velocity_walk=float(np.hypot(walk, robot.momentum_walk.force / robot.mass)),
        accelerometer_bias=max(force.turn_on_std, LEAST),
        accelerometer_walk=force.bias_walk,
        joint_rates=(joints.white_noise or 0.0) / MEMORY if derived else 0.0,
        momentum_walk=float(np.hypot(robot.momentum_walk.torque, seen_to_walk)),
        accelerometer=samples.biased,
        declared=bool(velocity),
    )


def declared_noise(robot: Robot, dt: float, velocity: float | None) -> Noise:
    """The noise of samples whose rates and velocity are measured, as declared.

    Args:
        robot: with its sensors.
        dt: from sample to sample, s.
        velocity: standard deviation of a velocity sample, m/s; None where there is
            none.

    Raises:
        InputError: the gyro's noise is not declared.
    """
    gyro = robot.sensors.gyro or GyroSpec()
    attitude = robot.sensors.attitude or AttitudeSpec(angle=0.0)
    joints = robot.sensors.joints or EncoderSpec(position=0.0)
    white = gyro.white_std(dt)
    if not white:
        raise InputError(
            f"{robot.name}: sensors: found no noise of the gyro; give "
            "gyro.angle_random_walk in the robot file ('orbident noise' finds it from "
            "a recording at rest)"
        )
    return Noise(
        gyro=float(np.hypot(white, declared_rate_noise(robot))),
        velocity=max(velocity or 0.0, LEAST),
        gyro_bias=max(gyro.turn_on_std, LEAST),
        gyro_walk=gyro.bias_walk,
        attitude=_as_white(attitude, dt),
        joint_rates=joints.tachometer or (joints.white_noise or 0.0) / MEMORY,
    )


def _changing(sensor: TrackerSpec) -> float:
    """How much the noise of a pose changes within `MEMORY`, rad or m."""
    lasting = sensor.coloured
    markov = lasting.markov_std**2 * -np.expm1(-MEMORY / lasting.correlation_time)
    walk = lasting.random_walk**2 * MEMORY
    return float(np.sqrt(sensor.white_noise**2 + (2 * markov + walk).max()))


def _as_white(attitude: AttitudeSpec, dt: float) -> float:
    """White noise that tells as little as that of an attitude, rad.

    The spectral density of a first-order Gauss-Markov process is at most
    `2 markov_std^2 correlation_time`; that of white noise is its variance times `dt`.
    """
    lasting = attitude.coloured
    markov = 2 * lasting.markov_std**2 * lasting.correlation_time / dt
    return float(np.sqrt(attitude.white_noise**2 + markov.max()))


def _spin(robot: Robot, samples: Samples) -> float:
    """The wheels' momentum, root mean square, which a wrong attitude turns, N m s."""
    if not robot.wheels:
        return 0.0
    h_rw = wheels_of(robot).A_rw @ np.array(samples.qd_rw)
    return float(np.sqrt(np.nanmean(np.sum(h_rw**2, axis=0))))


def _left_over(robot: Robot, samples: Samples) -> float:
    """What least squares leaves of a velocity that no sensor is declared for, m/s."""
    fits = fit(robot, minimal_sets(robot), samples, "unknown", lambda _: None)
    return max(fits.phi.rms, LEAST)


class FilterInput(NamedTuple):
    """A recording, as the filter takes it: at least one sample, all complete."""

    t: Float[np.ndarray, " n"]
    samples: Float[np.ndarray, "n all"]
    """Packed, one a row."""
    noise: Noise


class Pieces(NamedTuple):
    """The same of a recording that may be long."""

    noise: Noise
    every: Callable[[], Iterator[Piece]]
    """From the first one each time; some may be empty."""


def filter_input_of(
    robot: Robot, samples: Samples, torques: Torques | None = None
) -> FilterInput:
    """All samples that are as good as they are said to be.

    Args:
        robot: with its sensors.
        samples: of a recording.
        torques: of its joints, where they are used.

    Raises:
        InputError: there is none, or the noise of the base rate is not known.
    """
    settings = Settings()
    rate = smoothed_rate(samples, settings)
    noise, impulses = noise_of(robot, samples, rate_scatter(samples, settings)), None
    if torques is not None:
        noise, impulses = noise._replace(driven=torques.driven), torques.impulses
    t, every = packed_piece(samples, rate, trusted(samples), impulses)
    if not t.size:
        raise none_complete(samples.source)
    return FilterInput(t, every, noise)


def none_complete(source: str) -> InputError:
    """The error of a recording without a complete sample."""
    return InputError(
        f"{source}: no complete sample; record joints, wheels, gyro and attitude "
        "together"
    )


def pieces_of(problem: MomentumProblem) -> Pieces:
    """The same, stretch by stretch where a recording is read so.

    Raises:
        InputError: as `given_of`.
    """
    robot, samples, kept = problem.robot, problem.samples, problem.pieces
    if kept is None:
        torques = torques_of(robot, problem.recording, samples, problem.late)
        given = filter_input_of(robot, samples, torques)
        return Pieces(given.noise, lambda: iter([Piece(given.t, given.samples)]))
    noise = noise_of(robot, samples, rate_scatter(samples, Settings()))
    return Pieces(noise, lambda: ahead(kept()))
