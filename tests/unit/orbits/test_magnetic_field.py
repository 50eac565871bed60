"""The magnetic field against published poles."""

from datetime import UTC, datetime

import numpy as np
import pytest

from orbident.errors import InputError
from orbident.orbits.earth import R_E, dipole_field, earth_turned, reference_field
from orbident.orbits.orbit import Elements, Orbit

FLAT = 0.0066943799901
"""Squared eccentricity of WGS84."""


def on_the_ground(latitude: float, longitude: float) -> tuple[np.ndarray, ...]:
    """The place, m, of geodetic latitude and longitude, deg, and what is up there."""
    a, b = np.radians([latitude, longitude])
    up = np.array([np.cos(a) * np.cos(b), np.cos(a) * np.sin(b), np.sin(a)])
    N = R_E / np.sqrt(1 - FLAT * np.sin(a) ** 2)
    return N * up * [1, 1, 1 - FLAT], up


@pytest.mark.parametrize("hours", [0, 7])
@pytest.mark.parametrize(
    ("year", "latitude", "longitude", "sign"),
    [
        (1965, 75.63, -101.34, -1),
        (1965, -66.33, 139.53, 1),
        (1980, 76.91, -101.68, -1),
        (1980, -65.42, 139.35, 1),
    ],
)
def test_the_field_is_upright_at_the_dip_poles(
    year: int, latitude: float, longitude: float, sign: int, hours: int
):
    """Alken et al. 2021, Table 4, at definitive epochs, at any time of the day."""
    epoch, t = datetime(year, 1, 1, tzinfo=UTC), np.array([3600.0 * hours])
    r, up = on_the_ground(latitude, longitude)
    (turned,) = earth_turned(epoch, t)
    c, s = np.cos(turned), np.sin(turned)
    R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    (B,) = reference_field(epoch, t, (R @ r)[None])
    upright = B @ (R @ up)
    assert sign * upright > 5e-5
    # Poles are given to 0.01 deg, 1.1 km; there the field tilts by 1 nT in 10 to 30 m
    # of 6e-5 T: up to 1e-7 T.
    assert np.linalg.norm(B - upright * (R @ up)) < 1e-7


def test_the_model_ends():
    r = np.array([[7e6, 0.0, 0.0]])
    with pytest.raises(InputError, match=r"epoch 1850-01-01.*knows 1900 to 20"):
        reference_field(datetime(1850, 1, 1, tzinfo=UTC), np.zeros(1), r)


def test_a_dipole_is_twice_as_strong_over_the_poles():
    equator, pole = dipole_field(R_E * np.eye(3)[[0, 2]])
    np.testing.assert_allclose(equator, [0, 0, 2.98e-5], atol=1e-20)
    np.testing.assert_allclose(pole, [0, 0, -5.96e-5], atol=1e-20)


def test_an_orbit_over_the_pole_has_a_field():
    """Between its grid points too, where east and north are two directions."""
    polar = Elements(7e6, np.pi / 2)
    epoch = datetime(2024, 1, 1, tzinfo=UTC)
    t = np.linspace(0.0, 5800.0, 777)
    arc = Orbit(polar, epoch).arc(0.0, 5800.0)
    direct = reference_field(epoch, t, arc.position(t))
    # A millionth of the field, whose waves take seven minutes and more.
    np.testing.assert_allclose(arc.field(t), direct, atol=1e-10)
