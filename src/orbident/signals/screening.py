"""What of a recording cannot be true: dead sensors, impossible angles, spikes."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.recordings.columns import VECTORS, is_known
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.signals.outliers import find_spikes

FEWEST = 10
"""Samples: fewer that are equal may be so by chance."""

MOVED = 1e-3
"""rad or m: a joint that moved more turns the base."""

MARGIN = 0.05
"""Of a joint's range: beyond its stops by so much it cannot have been."""


@dataclass(frozen=True)
class Screened:
    """A recording without what cannot be true, and what was taken out."""

    recording: Recording
    rejected: Mapping[str, Mapping[str, int]]
    """By column and reason, how many samples."""


def screened(robot: Robot, recording: Recording) -> Screened:
    """Refuse what makes a recording useless; take out what spoils it.

    Args:
        robot: with the ranges of its joints.
        recording: of any sensors.

    Raises:
        InputError: a sensor shows one value throughout while joints move, or a joint
            was beyond its stops.
    """
    _check_ranges(robot, recording)
    _check_alive(robot, recording)
    columns, rejected = dict(recording.columns), {}
    for names in _sensors(recording):
        masks = {name: _spikes(recording, name) for name in names}
        for name, mask in masks.items():
            if mask.any():
                rejected[name] = {"spike": int(mask.sum())}
        anywhere = np.logical_or.reduce(list(masks.values()))
        if anywhere.any():
            for name in names:
                columns[name] = np.where(anywhere, np.nan, columns[name])
    if not rejected:
        return Screened(recording, {})
    return Screened(replace(recording, columns=columns), rejected)


def in_words(rejected: Mapping[str, Mapping[str, int]]) -> tuple[str, ...]:
    """What was taken out."""
    return tuple(
        f"{column}: {count} {reason}{'' if count == 1 else 's'} left out"
        for column, reasons in rejected.items()
        for reason, count in reasons.items()
    )


def _sensors(recording: Recording) -> list[list[str]]:
    """The columns that belong together: a bad component spoils the others."""
    groups: dict[str, list[str]] = {}
    for name in recording.columns:
        if is_known(name):
            head = name.split(".", 1)[0]
            groups.setdefault(head if head in VECTORS else name, []).append(name)
    return [names for head, names in groups.items() if head not in {"force", "torque"}]


def _spikes(recording: Recording, name: str) -> np.ndarray:
    column = recording.columns[name]
    if np.isfinite(column).sum() < FEWEST:
        return np.zeros(column.size, dtype=bool)
    return find_spikes(recording.t, column, f"{recording.source}: '{name}'").mask


def _check_ranges(robot: Robot, recording: Recording) -> None:
    for joint in robot.joints:
        name = f"joint.{joint.name}.position"
        if joint.position is None or not recording.has(name):
            continue
        q = recording.column(name)
        lower, upper = joint.position
        slack = MARGIN * (upper - lower)
        beyond = np.flatnonzero((q < lower - slack) | (q > upper + slack))
        if beyond.size:
            raise InputError(
                f"{recording.source}: column '{name}': {beyond.size} of {q.size} "
                f"samples beyond the joint's range {lower:g} to {upper:g}, the first "
                f"{q[beyond[0]]:.6g} at t = {recording.t[beyond[0]]:g} s; check the "
                "encoder and its unit (rad), or the limits in the robot file"
            )


def _check_alive(robot: Robot, recording: Recording) -> None:
    moved = next((n for n in robot.joint_names if _moved(recording, n)), None)
    if moved is None:
        return
    for names in _sensors(recording):
        sensor = names[0].split(".", 1)[0]
        columns = [_measured(recording, name) for name in names]
        if sensor not in VECTORS or any(column.size < FEWEST for column in columns):
            continue
        still = [not np.ptp(column) for column in columns]
        stuck = [
            name
            for name, column, dead in zip(names, columns, still, strict=True)
            if dead and (all(still) or column[0])
        ]
        # In a symmetric or planar motion a component may well stay zero, and a
        # quaternion's or the position of one axis may stay what it was.
        if stuck and (all(still) or sensor in {"gyro", "accelerometer"}):
            raise InputError(
                f"{recording.source}: column '{stuck[0]}' is "
                f"{_measured(recording, stuck[0])[0]:g} throughout while joint "
                f"'{moved}' moves: is the sensor dead? remove the columns "
                f"'{sensor}.*' or record again"
            )


def _moved(recording: Recording, joint: str) -> bool:
    name = f"joint.{joint}.position"
    if not recording.has(name):
        return False
    q = _measured(recording, name)
    return bool(q.size and np.ptp(q) > MOVED)


def _measured(recording: Recording, name: str) -> Float[np.ndarray, " n"]:
    column = recording.columns[name]
    return column[~np.isnan(column)]
