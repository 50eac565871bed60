"""Ready-made sensors, in the form of `Robot.sensors`.

In a robot file, `sensors: {suites: [tactical-imu, phasespace-like]}`.

Only the paper's is anybody's specification. The others have typical numbers of their
kind of instrument, rounded, to try an identification with before there is hardware.
"""

from collections.abc import Mapping
from typing import Any

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
