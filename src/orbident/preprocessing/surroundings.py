"""Where the Earth, the air, the sun and the magnetic field are, seen from the base."""

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.recordings.recording import Recording

GROUND = 6.35e6
"""m: less than the Earth's radius at its poles."""

UNIT = 0.01
"""What the norm of a direction may differ from one by."""

STRONGEST = 7e-5
"""T: the Earth's field at its poles, on the ground."""

Surroundings = Mapping[str, Float[np.ndarray, "samples 3"]]


def surroundings(recording: Recording) -> Surroundings:
    """The recorded vectors, base axes; between their samples they change evenly.

    Raises:
        InputError: an orbit is below the ground, a direction has not the norm one, or
            the field is stronger than the Earth's.
    """
    found = {}
    for name in ("nadir", "flow", "sun", "field"):
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
    return found


def _check(where: str, name: str, shown: Float[np.ndarray, "samples 3"]) -> None:
    size = np.linalg.norm(shown, axis=1)
    least, most = float(np.nanmin(size)), float(np.nanmax(size))
    if name == "nadir" and least < GROUND:
        raise InputError(
            f"{where}: found a vector of {least:.4g} m, an orbit below the ground; "
            "give that from the robot to the middle of the Earth, base axes, in metres"
        )
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
