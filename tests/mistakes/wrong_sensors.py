"""Sensors that do not show what the robot file says, with their own noise."""

from typing import Any

import numpy as np
from edited_recordings import changed
from recordings import SEED, Clean
from spoiled import Spoil, Spoiled, spoiled

from orbident.model.rotations import quaternion_matrix
from orbident.simulation.measure import Truth


def sensed(sensor: str, **actual: Any) -> Spoil:
    """A sensor that is not as declared."""
    return lambda clean: spoiled(
        clean, recording=clean.recorded(sensors={sensor: actual})
    )


def clock(sensor: str, late: float, rate: float = 1.0) -> Spoil:
    """One sensor shows what was at `rate t - late`; its first samples are missing."""

    def spoil(clean: Clean) -> Spoiled:
        at = rate * clean.t - late
        inside = np.clip(at, 0.0, clean.t[-1])
        seen = clean.at(_rising(inside))
        recording = clean.recorded(clean.true._replace(**_of(sensor, seen)))
        missing = {
            name: np.where((at < 0) | (at > clean.t[-1]), np.nan, column)
            for name, column in recording.columns.items()
            if name.startswith(sensor)
        }
        return spoiled(clean, recording=changed(recording, missing))

    return spoil


def _rising(t: np.ndarray) -> np.ndarray:
    """Equal times at the ends, of samples that will be missing, a little apart."""
    return t + 1e-9 * np.arange(t.size) / t.size


def _of(sensor: str, seen: Truth) -> dict[str, np.ndarray]:
    """The fields of a truth that a sensor shows."""
    fields = {"joint": ("q", "qd"), "wheel": ("q_rw", "qd_rw")}
    return {name: getattr(seen, name) for name in fields.get(sensor, (sensor,))}


def jitter(part: float) -> Spoil:
    """Rows are sampled off their times by this part of a row."""

    def spoil(clean: Clean) -> Spoiled:
        random = np.random.default_rng(SEED)
        dt = clean.t[1] - clean.t[0]
        off = part * dt * random.uniform(-1, 1, clean.t.size)
        off[0] = 0.0  # The motion starts at the first time.
        at = np.clip(clean.t + off, 0.0, clean.t[-1])
        true = clean.at(_rising(at))
        return spoiled(clean, recording=clean.recorded(true))

    return spoil


def marker(off: np.ndarray) -> Spoil:
    """The position is that of a point so far from S, base axes, m."""

    def spoil(clean: Clean) -> Spoiled:
        R_WB = quaternion_matrix(clean.true.attitude)
        position = clean.true.position + R_WB @ off
        true = clean.true._replace(position=position)
        return spoiled(clean, recording=clean.recorded(true))

    return spoil


def flexible(frequency: float) -> Spoil:
    """Encoders on the motors of joints that give way: `q_m = q + qdd / (2 pi f)^2`."""

    def spoil(clean: Clean) -> Spoiled:
        _, _, qdd = clean.joints.at(clean.t)
        q = clean.true.q + qdd / (2 * np.pi * frequency) ** 2
        return spoiled(clean, recording=clean.recorded(clean.true._replace(q=q)))

    return spoil
