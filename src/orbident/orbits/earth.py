"""The Earth as it is seen in J2000 axes (z its axis, x to the equinox of 2000).

    turned   2 pi (0.7790572732640 + 1.00273781191135448 d)   angle of rotation
    sun      M = 357.5256 deg + 35999.049 deg T,
             longitude P + M + 6892'' sin M + 72'' sin 2M, on the ecliptic,
             P = 282.937 deg + 0.323 deg T
    dipole   B = B_0 (R_E / R)^3 (e_z - 3 (e_z . n) n)     n up; along the Earth's axis
    IGRF     the library ppigrf, at the epoch, turned with the Earth

`d` are days and `T` centuries since noon of 1 January 2000 (IERS Conventions 2010, Eq.
5.15; Montenbruck and Gill, Satellite Orbits, Sec. 3.3.2, with the motion of the
perihelion by Simon et al. 1994). That the Earth's axis moves, 0.15 deg until 2026, is
left out.
"""

from datetime import UTC, datetime

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.extras import extra

MU = 3.986004418e14
"""The Earth's gravitational parameter, m^3/s^2."""

R_E = 6378137.0
"""Radius of the Earth at the equator, m."""

J2 = 1.08262668e-3
"""How flat its field is: the second zonal harmonic."""

AXIS = np.array([0.0, 0.0, 1.0])

TURN = 7.2921159e-5
"""The rate of the Earth and of its air, rad/s."""

DAY = 86400.0
"""s."""

NOON = datetime(2000, 1, 1, 12, tzinfo=UTC)
"""The epoch J2000."""

OBLIQUITY = np.radians(23.43929111)

SUN_RADIUS = 4.654e-3
"""The angle of the sun's radius, rad."""

Vectors = Float[np.ndarray, "n 3"]


def _days(epoch: datetime, t: Float[np.ndarray, " n"]) -> Float[np.ndarray, " n"]:
    return ((epoch - NOON).total_seconds() + t) / DAY


def earth_turned(
    epoch: datetime, t: Float[np.ndarray, " n"]
) -> Float[np.ndarray, " n"]:
    """The angle by which the Earth has turned from inertial x to Greenwich, rad.

    The epoch is `t = 0` s; UTC is taken for UT1, which it is within 0.9 s.
    """
    d = _days(epoch, t)
    # Whole turns are left out before they cost digits.
    return 2 * np.pi * ((0.7790572732640 + 0.00273781191135448 * d + d % 1.0) % 1.0)


def to_the_sun(epoch: datetime, t: Float[np.ndarray, " n"]) -> Vectors:
    """Unit vectors from the Earth to the sun, `t` s after the epoch; J2000 axes."""
    T = _days(epoch, t) / 36525
    M = np.radians(357.5256 + 35999.049 * T)
    arcsec = np.radians(1 / 3600)
    perihelion = np.radians(282.937 + 0.323 * T)
    along = perihelion + M + arcsec * (6892 * np.sin(M) + 72 * np.sin(2 * M))
    y = np.sin(along)
    return np.stack(
        [np.cos(along), np.cos(OBLIQUITY) * y, np.sin(OBLIQUITY) * y], axis=1
    )


def sunlit(r: Vectors, sun: Vectors) -> Float[np.ndarray, " n"]:
    """The part of the sun's disc that the Earth does not hide, 0 to 1.

    In between, as the disc goes behind the horizon, its height counts as its area. The
    places `r` are from the middle of the Earth, m; `sun` are unit vectors to the sun.
    """
    R = np.linalg.norm(r, axis=1)
    from_nadir = np.arccos(np.clip(-np.sum(r * sun, axis=1) / R, -1.0, 1.0))
    above = from_nadir - np.arcsin(np.clip(R_E / R, 0.0, 1.0))
    return np.clip(0.5 + above / (2 * SUN_RADIUS), 0.0, 1.0)


FIELD = 2.98e-5
"""The dipole's field at the equator, on the ground, T."""

POLE = 1e-4
"""deg: 11 m from the axis east and north are two directions."""


def dipole_field(r: Vectors) -> Vectors:
    """The field of a dipole along the Earth's axis, T, at `r` from its middle, m."""
    R = np.linalg.norm(r, axis=1, keepdims=True)
    n = r / R
    return FIELD * (R_E / R) ** 3 * (AXIS - 3 * (n @ AXIS)[:, None] * n)


def reference_field(epoch: datetime, t: Float[np.ndarray, " n"], r: Vectors) -> Vectors:
    """The International Geomagnetic Reference Field (IGRF) at the epoch, T.

    The places `r`, `t` s after the epoch, are from the middle of the Earth, m.

    Raises:
        InputError: the epoch is not one of the model.
        MissingLibraryError: ppigrf is not installed.
    """
    with extra("orbit", "the magnetic field of a date"):
        import ppigrf.ppigrf as igrf
    date = epoch.astimezone(UTC).replace(tzinfo=None)
    known = igrf.read_shc()[0].index
    first, last = known[0].to_pydatetime(), known[-1].to_pydatetime()
    # Of another date it would be extrapolated.
    if not first <= date <= last:
        raise InputError(
            f"orbit: epoch {date:%Y-%m-%d}: the model of the magnetic field (IGRF) "
            f"knows {first:%Y} to {last:%Y}; give columns field.x .y .z, correct the "
            "epoch, or update ppigrf"
        )
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
