"""Ready-made sensors, in the form of `Robot.sensors`.

In a robot file, `sensors: {suites: [tactical-imu, phasespace-like]}`.

Only the paper's is anybody's specification. The others have typical numbers of their
kind of instrument, rounded, to try an identification with before there is hardware.

What the noise of attitude and position has beside white noise.

The cameras of motion capture and the markers that they see are not white: their errors
last. Each axis has two processes of its own, and all are independent. A first-order
Gauss-Markov process has a standard deviation `s` and a correlation time `T`:

    cov(x(t), x(t + tau)) = s^2 exp(-|tau| / T)

A random walk has a density `q`, and is zero at the first sample:

    var(x(t)) = q^2 t

How the bias of a gyro or an accelerometer wanders, from what its data sheet gives.

A data sheet's bias instability `B` is the coefficient of flicker noise, whose Allan
deviation is flat, `sqrt(2 ln 2 / pi) B = 0.664 B` (IEEE Std 952, C.1.3). Flicker noise
has no finite-dimensional model. A first-order Gauss-Markov process (C.1.5) with
standard deviation `s` and correlation time `T` has an Allan deviation that peaks at
`0.617 s`; with the same peak, `s = 0.664 B / 0.617 = 1.076 B`. For times short beside
`T` its increments have the variance `2 s^2 (1 - exp(-dt/T)) = (2 s^2 / T) dt`: it is a
random walk of `s sqrt(2 / T)` per square root of a second.
"""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.files.names import suggestion
from orbident.robot.units import quantity

SUITES: Mapping[str, Mapping[str, Mapping[str, Any]]] = {
    # Section 3.5: the IMU, and encoders on the motors of joints and wheels.
    "paper": {
        "gyro": {
            "angle_random_walk": quantity("0.01 deg/sqrt(h)", "angle random walk"),
            "bias_instability": quantity("0.3 deg/h", "angular rate"),
        },
        "accelerometer": {
            "velocity_random_walk": quantity(
                "0.001 m/s/sqrt(h)", "velocity random walk"
            ),
            "bias_instability": quantity("10 ug", "acceleration"),
        },
        "joints": {"position": 2.5e-5},
        "wheels": {"position": 2.5e-5},
    },
    # A small tactical-grade MEMS unit (Sensonor STIM300, 10 g); what its data sheet
    # calls repeatability is the bias at turn-on. One count of its gyro is far smaller.
    "tactical-imu": {
        "gyro": {
            "angle_random_walk": quantity("0.15 deg/sqrt(h)", "angle random walk"),
            "bias_instability": quantity("0.5 deg/h", "angular rate"),
            "turn_on_bias": quantity("4 deg/h", "angular rate"),
            "scale": (5e-4, 5e-4, 5e-4),
            "misalignment": (1e-3, 1e-3, 1e-3),
        },
        "accelerometer": {
            "velocity_random_walk": quantity(
                "0.07 m/s/sqrt(h)", "velocity random walk"
            ),
            "bias_instability": quantity("0.05 mg", "acceleration"),
            "turn_on_bias": quantity("0.75 mg", "acceleration"),
            "scale": (3e-4, 3e-4, 3e-4),
            "misalignment": (1e-3, 1e-3, 1e-3),
        },
    },
    # Eight cameras and active markers on a robot half a metre wide: a tenth of a
    # millimetre of a marker is a third of a milliradian of the robot. Markers are
    # hidden behind an arm now and then.
    "phasespace-like": {
        "attitude": {
            "angle": quantity("0.02 deg", "angle"),
            "latency": 5e-3,
            "drop_out": 0.01,
        },
        "position": {
            "std": quantity("0.1 mm", "length"),
            "latency": 5e-3,
            "drop_out": 0.01,
        },
    },
    # A consumer-size IMU, and a camera that knows its surroundings: centimetres and
    # tenths of degrees, twice a second, after the image has been processed.
    "astrobee-like": {
        "gyro": {
            "angle_random_walk": quantity("0.1 deg/sqrt(h)", "angle random walk"),
            "bias_instability": quantity("3 deg/h", "angular rate"),
        },
        "accelerometer": {
            "velocity_random_walk": quantity(
                "0.04 m/s/sqrt(h)", "velocity random walk"
            ),
            "bias_instability": quantity("0.1 mg", "acceleration"),
        },
        "joints": {"position": 5e-4, "resolution": quantity("0.088 deg", "angle")},
        "attitude": {
            "angle": quantity("0.5 deg", "angle"),
            "rate": 2.0,
            "latency": 0.2,
            "drop_out": 0.1,
        },
        "position": {
            "std": quantity("2 cm", "length"),
            "rate": 2.0,
            "latency": 0.2,
            "drop_out": 0.1,
        },
    },
}
"""Suites of sensors, SI. Rates not given are those of the recording's rows."""


def sensor_suite(name: str) -> dict[str, dict[str, Any]]:
    """A copy of a ready-made sensor section.

    Raises:
        InputError: there is none of this name.
    """
    if name not in SUITES:
        raise InputError(
            f"sensor suite {name!r}: {suggestion(name, SUITES, 'sensor suites')}"
        )
    return {key: dict(section) for key, section in SUITES[name].items()}


PerAxis = float | tuple[float, float, float]
"""One number for all axes, or one for each."""


class Coloured(NamedTuple):
    """The parts that are not white, by axis; zero where there are none."""

    markov_std: Float[np.ndarray, "3"]
    """`s`, m or rad."""
    correlation_time: Float[np.ndarray, "3"]
    """`T`, s; 1 where there is no such part."""
    random_walk: Float[np.ndarray, "3"]
    """`q`, m/sqrt(s) or rad/sqrt(s)."""

    @property
    def absent(self) -> bool:
        """Whether the noise is white."""
        return not (self.markov_std.any() or self.random_walk.any())


WHITE = Coloured(np.zeros(3), np.ones(3), np.zeros(3))
"""Nothing lasts."""


def coloured_noise(section: Mapping[str, Any]) -> Coloured:
    """The parts that the robot file declares.

    Args:
        section: of attitude or position; empty where the file has none.
    """
    std, time, walk = (
        np.broadcast_to(np.asarray(section.get(name) or default, np.float64), 3)
        for name, default in (
            ("markov_std", 0.0),
            ("correlation_time", 1.0),
            ("random_walk", 0.0),
        )
    )
    return Coloured(std, np.where(std > 0, time, 1.0), walk)


CORRELATION_TIME = 3600.0
"""s. Data sheets give none; an hour is usual for tactical-grade units, and makes the
bias of a record of minutes all but constant, as the paper's own error analysis has it.
"""

FLICKER_FLOOR = math.sqrt(2 * math.log(2) / math.pi)
"""Allan deviation of flicker noise over its coefficient B: 0.664."""

MARKOV_PEAK = 0.617364
"""Largest Allan deviation of a first-order Gauss-Markov process over its std."""

UNKNOWN_BIAS = {"gyro": 0.1, "accelerometer": 1.0}
"""Std of an undeclared bias, rad/s and m/s^2: more than any sensor's."""


def markov_std(B: float) -> float:
    """Std of the Gauss-Markov process with flicker's floor, in the unit of `B`."""
    return FLICKER_FLOOR / MARKOV_PEAK * B


def bias_walk(sensor: Mapping[str, Any]) -> float:
    """The random walk of a bias, in the bias's unit per square root of a second.

    Args:
        sensor: the section of the robot file; empty where it has none.
    """
    T = sensor.get("correlation_time", CORRELATION_TIME)
    return markov_std(sensor.get("bias_instability", 0.0)) * math.sqrt(2 / T)


def bias_std(name: str, sensor: Mapping[str, Any]) -> float:
    """Std of the bias at the first sample, before it is estimated.

    The bias instability says how the bias wanders, not how large it is at turn-on.

    Args:
        name: `"gyro"` or `"accelerometer"`.
        sensor: its section of the robot file; empty where it has none.
    """
    std = sensor.get("turn_on_bias")
    return UNKNOWN_BIAS[name] if std is None else float(std)
