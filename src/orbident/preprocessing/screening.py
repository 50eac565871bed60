"""What of a recording cannot be true: dead sensors, impossible angles, spikes."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.preprocessing.outliers import find_spikes
from orbident.recordings.columns import VECTORS, is_known
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot

FEWEST = 10
"""Samples: fewer that are equal may be so by chance."""

MOVED = 1e-3
"""rad or m: a joint that moved more turns the base."""

MARGIN = 0.05
"""Part of a joint's range: beyond its stops by so much it cannot have been."""


FARTHER = 2.0
"""Times its range: no wrong zero, and no stop that was measured badly, lets a joint
move so far."""

NO_SENSORS = {
    *("force", "torque", "thruster", "torquer"),
    *("nadir", "flow", "sun", "field"),
}
"""Columns of what acts: it may change at once, and is not measured on the robot."""

UNITS = {"revolute": ("rad", "degrees", 2 * np.pi), "prismatic": ("m", "mm", 1.0)}
"""The unit of each kind of joint, the unit it is mistaken for, and a motion that is
nothing much in the wrong unit, but farther than joints with stops go in the right one.
"""

TILTED = 0.2
"""Sine of a tilt: no table is so steep, nor motion capture mounted so badly."""

MOSTLY = 0.9
"""Part of the samples that counts as all: single ones may be wrong."""


@dataclass(frozen=True)
class Screened:
    """A recording without what cannot be true, and what was taken out."""

    recording: Recording
    rejected: Mapping[str, Mapping[str, int]]
    """How many samples were rejected, by column and reason."""
    notes: tuple[str, ...] = ()
    """What cannot quite be true, and was left as it is."""


def screened(robot: Robot, recording: Recording) -> Screened:
    """Refuse what makes a recording useless; take out what spoils it.

    Args:
        robot: with the ranges of its joints.
        recording: of any sensors.

    Raises:
        InputError: a sensor shows one value throughout while joints move, a joint's
            positions are in another unit, or the attitude of a planar robot leaves the
            plane.
    """
    notes = tuple(_beyond_ranges(robot, recording))
    _check_alive(robot, recording)
    _check_in_plane(robot, recording)
    return replace(without_spikes(recording), notes=notes)


def without_spikes(recording: Recording, own: slice = np.s_[:]) -> Screened:
    """Take out spikes.

    Args:
        recording: of any sensors.
        own: the rows in which spikes are counted.
    """
    spoiled, rejected = {}, {}
    for names in _sensors(recording):
        spiky = {name: _spikes(recording, name) for name in names}
        bad = np.logical_or.reduce([*spiky.values()])
        for name in names if bad.any() else ():
            spoiled[name] = np.where(bad, np.nan, recording.columns[name])
        for name, rows in spiky.items():
            if count := int(rows[own].sum()):
                rejected[name] = {"spike": count}
    if not spoiled:
        return Screened(recording, {})
    columns = {**recording.columns, **spoiled}
    return Screened(replace(recording, columns=columns), rejected)


def spikes_in_words(rejected: Mapping[str, Mapping[str, int]]) -> tuple[str, ...]:
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
        head = name.split(".", 1)[0]
        if is_known(name) and head not in NO_SENSORS:
            groups.setdefault(head if head in VECTORS else name, []).append(name)
    return list(groups.values())


def _spikes(recording: Recording, name: str) -> np.ndarray:
    column = recording.columns[name]
    if np.isfinite(column).sum() < FEWEST:
        return np.zeros(column.size, dtype=bool)
    return find_spikes(recording.t, column, f"{recording.source}: '{name}'").mask


def _beyond_ranges(robot: Robot, recording: Recording) -> Iterator[str]:
    """Where joints were beyond their stops, in words.

    Raises:
        InputError: one moved as far as only another unit makes it.
    """
    for joint in robot.joints:
        name = f"joint.{joint.name}.position"
        if joint.position is None or not recording.has(name):
            continue
        q = recording.column(name)
        lower, upper = joint.position
        slack = MARGIN * (upper - lower)
        beyond = np.flatnonzero((q < lower - slack) | (q > upper + slack))
        if not beyond.size:
            continue
        found = (
            f"column '{name}': {beyond.size} of {q.size} samples beyond the joint's "
            f"range {lower:g} to {upper:g}, the first {q[beyond[0]]:.6g} at "
            f"t = {recording.t[beyond[0]]:g} s"
        )
        right, wrong, least = UNITS[joint.kind]
        if np.nanmax(q) - np.nanmin(q) > max(least, FARTHER * (upper - lower)):
            raise InputError(
                f"{recording.source}: {found}; it seems to be in {wrong}: give {right}"
            )
        yield f"{found}; check the encoder's zero, or the limits in the robot file"


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


def _check_in_plane(robot: Robot, recording: Recording) -> None:
    names = [f"attitude.{k}" for k in "xyzw"]
    if robot.motion != "planar" or not recording.has(*names):
        return
    x, y, z, w = (recording.column(name) for name in names)
    # The sine of the angle between the base's z axis and the inertial one.
    sine = 2 * np.sqrt((x**2 + y**2) * (z**2 + w**2))
    known = sine[~np.isnan(sine)]
    if not known.size or np.quantile(known, MOSTLY) < TILTED:
        return
    # Scalar first, a turn about z has its zeros in the second and third place.
    scalar_first = np.nanquantile(np.hypot(y, z), MOSTLY) < TILTED
    cause = (
        "the quaternions seem to be scalar first: put the first number into "
        "attitude.w, and the others into attitude.x, .y and .z"
        if scalar_first
        else "give them scalar last, from base axes to inertial axes with z up; or say "
        "'motion: spatial' in the robot file"
    )
    raise InputError(
        f"{recording.source}: columns 'attitude.x' to '.w' tilt the base by up to "
        f"{np.degrees(np.arcsin(min(known.max(), 1.0))):.0f} deg, but '{robot.name}' "
        f"moves in a plane and turns about z only; {cause}"
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
