"""Ready-made sensors, as a robot file would have them.

In a robot file, `sensors: {suites: [tactical-imu, phasespace-like]}`.

Only the paper's is anybody's specification. The others have typical numbers of their
kind of instrument, rounded, to try an identification with before there is hardware.
"""

from collections.abc import Mapping
from typing import Any

SUITES: Mapping[str, Mapping[str, Mapping[str, Any]]] = {
    # Section 3.5: the IMU, and encoders on the motors of joints and wheels.
    "paper": {
        "gyro": {
            "angle_random_walk": "0.01 deg/sqrt(h)",
            "bias_instability": "0.3 deg/h",
        },
        "accelerometer": {
            "velocity_random_walk": "0.001 m/s/sqrt(h)",
            "bias_instability": "10 ug",
        },
        "joints": {"position": 2.5e-5},
        "wheels": {"position": 2.5e-5},
    },
    # A small tactical-grade MEMS unit (Sensonor STIM300, 10 g); what its data sheet
    # calls repeatability is the bias at turn-on. One count of its gyro is far smaller.
    "tactical-imu": {
        "gyro": {
            "angle_random_walk": "0.15 deg/sqrt(h)",
            "bias_instability": "0.5 deg/h",
            "turn_on_bias": "4 deg/h",
            "scale": (5e-4, 5e-4, 5e-4),
            "misalignment": (1e-3, 1e-3, 1e-3),
        },
        "accelerometer": {
            "velocity_random_walk": "0.07 m/s/sqrt(h)",
            "bias_instability": "0.05 mg",
            "turn_on_bias": "0.75 mg",
            "scale": (3e-4, 3e-4, 3e-4),
            "misalignment": (1e-3, 1e-3, 1e-3),
        },
    },
    # Eight cameras and active markers on a robot half a metre wide: a tenth of a
    # millimetre of a marker is a third of a milliradian of the robot. Markers are
    # hidden behind an arm now and then.
    "phasespace-like": {
        "attitude": {"angle": "0.02 deg", "latency": 5e-3, "drop_out": 0.01},
        "position": {"std": "0.1 mm", "latency": 5e-3, "drop_out": 0.01},
    },
    # A consumer-size IMU, and a camera that knows its surroundings: centimetres and
    # tenths of degrees, twice a second, after the image has been processed.
    "astrobee-like": {
        "gyro": {"angle_random_walk": "0.1 deg/sqrt(h)", "bias_instability": "3 deg/h"},
        "accelerometer": {
            "velocity_random_walk": "0.04 m/s/sqrt(h)",
            "bias_instability": "0.1 mg",
        },
        "joints": {"position": 5e-4, "resolution": "0.088 deg"},
        "attitude": {"angle": "0.5 deg", "rate": 2.0, "latency": 0.2, "drop_out": 0.1},
        "position": {"std": "2 cm", "rate": 2.0, "latency": 0.2, "drop_out": 0.1},
    },
}
"""Suites of sensors by name. Rates not given are those of the recording's rows."""
