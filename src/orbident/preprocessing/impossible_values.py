"""Recorded values that no real robot can have: some are refused, others only warned of.

A sensor that is dead while joints move, joints beyond their ranges, and an attitude out
of the plane of a planar robot.
"""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.recordings.columns import VECTORS
from orbident.recordings.no_measurements import sensor_groups
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

UNITS = {"revolute": ("rad", "degrees", 2 * np.pi), "prismatic": ("m", "mm", 1.0)}
"""The unit of each kind of joint, the unit it is mistaken for, and a motion that is
nothing much in the wrong unit, but farther than joints with stops go in the right one.
"""

TILTED = 0.2
"""Sine of a tilt: no table is so steep, nor motion capture mounted so badly."""

MOSTLY = 0.9
"""Part of the samples that counts as all: single ones may be wrong."""


def beyond_ranges(robot: Robot, recording: Recording) -> Iterator[str]:
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


def check_alive(robot: Robot, recording: Recording) -> None:
    """Refuse sensors of the base that show one value while joints move.

    Raises:
        InputError: one does.
    """
    moved = next((n for n in robot.joint_names if _moved(recording, n)), None)
    if moved is None:
        return
    for names in sensor_groups(recording.columns).values():
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


def check_in_plane(robot: Robot, recording: Recording) -> None:
    """Refuse an attitude that leaves the plane of a planar robot.

    Raises:
        InputError: it does.
    """
    if robot.motion != "planar" or not recording.has_vector("attitude"):
        return
    x, y, z, w = recording.vector("attitude").T
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
