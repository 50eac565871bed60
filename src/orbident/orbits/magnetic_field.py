"""The Earth's magnetic field; J2000 axes.

dipole   B = B_0 (R_E / R)^3 (e_z - 3 (e_z . n) n)     n up; along the Earth's axis
IGRF     the library ppigrf, at the epoch, turned with the Earth
"""

from datetime import UTC, datetime
from typing import Any

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.extras import extra
from orbident.orbits.earth import AXIS, R_E, Vectors, earth_turned

FIELD = 2.98e-5
"""The dipole's field at the equator, on the ground, T."""

POLE = 1e-4
"""deg: 11 m from the axis east and north are two directions."""


def dipole_field(r: Vectors) -> Vectors:
    """The field of a dipole along the Earth's axis, T.

    Args:
        r: places from the middle of the Earth, m.
    """
    R = np.linalg.norm(r, axis=1, keepdims=True)
    n = r / R
    return FIELD * (R_E / R) ** 3 * (AXIS - 3 * (n @ AXIS)[:, None] * n)


def reference_field(epoch: datetime, t: Float[np.ndarray, " n"], r: Vectors) -> Vectors:
    """The International Geomagnetic Reference Field (IGRF), T.

    Args:
        epoch: the time at t = 0, and that of the model.
        t: seconds after it.
        r: places from the middle of the Earth then, m.

    Raises:
        InputError: the epoch is not one of the model.
        MissingLibraryError: ppigrf is not installed.
    """
    with extra("orbit", "the magnetic field of a date"):
        import ppigrf.ppigrf as igrf
    date = epoch.astimezone(UTC).replace(tzinfo=None)
    _check_date(igrf, date)
    R = np.linalg.norm(r, axis=1)
    south = np.arccos(np.clip(r[:, 2] / R, -1, 1))
    east = np.arctan2(r[:, 1], r[:, 0])
    colatitude = np.clip(np.degrees(south), POLE, 180 - POLE)
    longitude = np.degrees(east - earth_turned(epoch, t))
    parts = igrf.igrf_gc(R / 1e3, colatitude, longitude, date)
    B_up, B_south, B_east = (1e-9 * np.ravel(part)[:, None] for part in parts)
    up = r / R[:, None]
    to_east = np.stack([-np.sin(east), np.cos(east), np.zeros_like(east)], axis=1)
    return B_up * up + B_south * np.cross(to_east, up) + B_east * to_east


def _check_date(igrf: Any, date: datetime) -> None:
    """Refuse a date that the model does not know: it would be extrapolated."""
    known = igrf.read_shc()[0].index
    first, last = known[0].to_pydatetime(), known[-1].to_pydatetime()
    if not first <= date <= last:
        raise InputError(
            f"orbit: epoch {date:%Y-%m-%d}: the model of the magnetic field (IGRF) "
            f"knows {first:%Y} to {last:%Y}; give columns field.x .y .z, correct the "
            "epoch, or update ppigrf"
        )
