"""How the bias of a gyro or an accelerometer wanders, from what its data sheet gives.

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
from typing import Any

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
