"""Where the Earth, the air, the sun and the magnetic field are, seen from the base."""

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.model.rotations import quaternion_matrix, rotate_back
from orbident.preprocessing.histories import Columns
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot

NAMES = ("nadir", "flow", "sun", "field")

GROUND = 6.35e6
"""m: less than the Earth's radius at its poles."""

UNIT = 0.01
"""What the norm of a direction may differ from one by."""

STRONGEST = 7e-5
"""T: the Earth's field at its poles, on the ground."""

Surroundings = Mapping[str, Float[np.ndarray, "samples 3"]]


def surroundings(robot: Robot, recording: Recording, x_WB: Columns) -> Surroundings:
    """The vectors in base axes, as they were recorded, or else of the robot's orbit.

    Between their samples they change evenly.

    Args:
        robot: perhaps with an orbit.
        recording: perhaps with columns.
        x_WB: the attitude at its samples.

    Raises:
        InputError: an orbit is below the ground, a direction has not the norm one, the
            field is stronger than the Earth's, or the orbit needs an attitude, or is
            not known at these times.
    """
    found: dict[str, Float[np.ndarray, "samples 3"]] = {}
    for name in NAMES:
        columns = [f"{name}.{axis}" for axis in "xyz"]
        if recording.has(*columns):
            shown = np.column_stack([recording.column(each) for each in columns])
            known = np.isfinite(shown).all(axis=1)
            if known.any():
                _check(f"{recording.source}: columns '{name}.x .y .z'", name, shown)
                t = recording.t
                found[name] = np.column_stack(
                    [np.interp(t, t[known], x[known]) for x in shown.T]
                )
    missing = [name for name in NAMES if name not in found]
    around = {**found, **_by_orbit(robot, recording, x_WB, missing)}
    # There is no sun in the Earth's shadow.
    return {name: vectors for name, vectors in around.items() if vectors.any()}


def _by_orbit(
    robot: Robot, recording: Recording, x_WB: Columns, names: Sequence[str]
) -> Surroundings:
    """The vectors of these names, as far as the robot's orbit tells them."""
    orbit, t = robot.orbit, recording.t
    if orbit is None or not names:
        return {}
    if not recording.has(*(f"attitude.{axis}" for axis in "xyzw")):
        raise InputError(
            f"{recording.source}: the robot file gives an orbit, and without "
            "attitude.x to .w nobody knows where the Earth is, seen from the base; add "
            "them, or remove 'orbit:' from the robot file"
        )
    try:
        arc = orbit.arc(float(t[0]), float(t[-1]))
        # Drag goes with the square of the speed, which is one in the mean.
        wind = arc.wind(t)
        speed = np.linalg.norm(wind, axis=1, keepdims=True)
        inertial = {
            "nadir": -arc.place(t),
            "flow": -speed * wind / np.mean(speed**2),
        }
        if orbit.epoch is not None:
            inertial["sun"] = arc.sun(t)
            if "field" in names:
                inertial["field"] = arc.field(t)
    except InputError as error:
        raise InputError(f"{recording.source}: {error}") from None
    # Where the attitude is not known, neither is what is seen from the base.
    R_WB = quaternion_matrix(np.column_stack(x_WB))
    return {
        name: rotate_back(R_WB, vectors)
        for name, vectors in inertial.items()
        if name in names
    }


def _check(where: str, name: str, shown: Float[np.ndarray, "samples 3"]) -> None:
    size = np.linalg.norm(shown, axis=1)
    least, most = float(np.nanmin(size)), float(np.nanmax(size))
    if name == "nadir" and least < GROUND:
        raise InputError(
            f"{where}: found a vector of {least:.4g} m, an orbit below the ground; "
            "give that from the robot to the middle of the Earth, base axes, in metres"
        )
    # The Earth may hide the sun, or a part of it.
    least = 1.0 if name == "sun" else least
    if name in {"flow", "sun"} and not 1 - UNIT < least <= most < 1 + UNIT:
        raise InputError(
            f"{where}: found a vector with norm {most:.4g}; give a direction with norm "
            "one, base axes"
        )
    if name == "field" and most > STRONGEST:
        raise InputError(
            f"{where}: found a field of {most:.3g} T, stronger than the Earth's; give "
            "tesla, base axes"
        )
