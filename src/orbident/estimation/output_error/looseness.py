"""How freely attitude, biases and joints may vary from one interval to the next."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.estimation.output_error.sensors import (
    RATE_WALK,
    Lasting,
    Sensors,
    between,
    first_lasting,
)
from orbident.gaussian import noisiest_std
from orbident.model.kinematics import principal_inertias
from orbident.preprocessing.origins import Origin
from orbident.preprocessing.rate_noise import momentum_noise
from orbident.preprocessing.samples import Samples, wheels_momentum
from orbident.robot.description import Robot
from orbident.robot.sensor_schema import AccelerometerSpec, GyroSpec

TURN_AND_BIASES = 9
"""The first unknowns of a boundary: turn, gyro bias and accelerometer bias."""

CONTINUOUS = 1e-9
"""rad/sqrt(s): what splines and integration add to the attitude."""

LOOSE_TURNS = 1e-2, 1e-3, 1e-4
"""rad/sqrt(s): the same in searches of which each leads to the next. What a CAD model
that is 20 % off turns a base otherwise is about as large as the first, so that its
errors and those of the attitude count alike."""

STEADY = 1e-6
"""Walk of a bias of which nothing is declared, over the noise of a sample."""

TAKEN_OVER = 1e9
"""rad/sqrt(s), where it is said elsewhere how far an attitude walks."""

SLIGHT = 1e-11
"""rad/s and m/s^2 per sqrt(s): with less, rounding hides what else is known of it."""

FIXED = 1e-9
"""rad: where nothing is seen in inertial axes, these are those of the first attitude;
and so they are in the plane without an attitude sensor, where all turns commute."""

TRACKED = "position", "velocity"
"""Sensors of S in inertial axes."""

BIAS = np.repeat([GyroSpec.UNKNOWN_BIAS, AccelerometerSpec.UNKNOWN_BIAS], 3)
"""Std of biases beforehand, rad/s and m/s^2."""

ENCODERS = 1e-2
"""Std of the error of smoothed encoders beforehand, rad or m, and per second; in a gap
it may be more."""

UNMEASURED = 1e2
"""The same of a joint that nobody measures: its own equations hold it."""


class Looseness(NamedTuple):
    """How freely what belongs to boundaries may vary: standard deviations."""

    corrected: Float[np.ndarray, " corrected"]
    """Indices of the joints that have corrections."""
    follows: Float[np.ndarray, "followers 3"]
    """A joint that follows, that with corrections which it follows, and its factor."""
    first: Float[np.ndarray, " local"]
    """Deviations of all unknowns of the boundary at the recording's start."""
    corrections: Float[np.ndarray, " corrections"]
    """Deviations of corrections anywhere: joints, rad or m; their rates, per second."""
    walk: Float[np.ndarray, "9"]
    """Random walk of attitude and biases, per square root of a second."""


def looseness(
    robot: Robot,
    samples: Samples,
    sensors: Sensors,
    lasting: Lasting,
    turning: float = CONTINUOUS,
) -> Looseness:
    """How freely attitude, biases and joints may vary from segment to segment.

    Args:
        robot: its nominal inertia says what errors of wheels do.
        samples: histories of joints and wheels.
        sensors: what they showed, with its noise.
        lasting: what lasts of that.
        turning: what the attitude walks at least, rad/sqrt(s).
    """
    turns = np.full(3, FIXED)
    seen = {"attitude"} if robot.motion == "planar" else {"attitude", *TRACKED}
    if seen & sensors.by_name.keys():
        # Nothing would hold a planar base's tilt, and it is none.
        turns[list(robot.conserved_axes[0])] = np.pi
    walks = []
    for name in ("gyro", "accelerometer"):
        sensed = sensors.by_name.get(name)
        walk = max(sensed.drift, STEADY * sensed.std, SLIGHT) if sensed else 1.0
        walks += 3 * [walk]
    # Joints whose rates are measured, or that do not move, have no corrections.
    free = [
        name in robot.passive
        or ("joints" in sensors.by_name and name not in {*samples.locked, *samples.led})
        for name in robot.joint_names
    ]
    at = {name: k for k, name in enumerate(robot.joint_names)}
    follows = [
        (at[name], at[lead.by], lead.factor)
        for name, lead in samples.led.items()
        if free[at[lead.by]]
    ]
    least = [
        UNMEASURED if name in robot.passive else ENCODERS for name in robot.joint_names
    ]
    std = np.maximum(np.array(least)[:, None], np.reshape(samples.worst, (-1, 2)))
    corrections = std[free].T.ravel()
    dt, D = float(np.median(np.diff(sensors.t))), principal_inertias(robot)[-1]
    noise = first_lasting(lasting, dt, float(D))
    turn_walk = np.full(3, max(turning, _turn_walk(robot, samples)))
    turn_walk[lasting[0, :, RATE_WALK] > 0] = TAKEN_OVER
    return Looseness(
        corrected=np.flatnonzero(free).astype(float),
        follows=np.reshape(follows, (-1, 3)).astype(float),
        first=np.concatenate([turns, BIAS, noise, corrections]),
        corrections=corrections,
        walk=np.array([*turn_walk, *walks]),
    )


def _turn_walk(robot: Robot, samples: Samples) -> float:
    """What joints and wheels between samples, and noise of speeds, add, rad/sqrt(s)."""
    rates = np.column_stack([samples.t, *samples.qd])
    rates = rates[np.isfinite(rates).all(axis=1)]
    dt = float(np.median(np.diff(rates[:, 0])))
    least = max(CONTINUOUS, between(rates[:, 0], rates[:, 1:]) * np.sqrt(dt))
    if samples.origins["wheel_speeds"] is not Origin.MEASURED or not robot.wheels:
        return least
    h_rw = wheels_momentum(robot, samples)
    known = np.isfinite(h_rw).all(axis=1)
    h_std = float(np.linalg.norm(momentum_noise(robot, samples.speeds), 2))
    h_std = h_std or noisiest_std(h_rw[known])
    rate = h_std / float(principal_inertias(robot)[0])
    return max(rate * np.sqrt(dt), least)
