"""How the Earth turns and where the sun is, against astropy."""

# astropy's coordinates get their attributes at run time.
# pyright: reportAttributeAccessIssue=false, reportArgumentType=false
# pyright: reportOptionalMemberAccess=false

from datetime import UTC, datetime

import astropy.units as u
import numpy as np
import pytest
from astropy.coordinates import GCRS, ITRS, CartesianRepresentation, get_sun
from astropy.time import Time
from astropy.utils import iers

from orbident.orbits.earth import R_E, earth_turned, sunlit, to_the_sun

DATES = [
    datetime(2003, 6, 21, 4, 30, tzinfo=UTC),
    datetime(2015, 12, 31, 23, 59, 59, tzinfo=UTC),
    datetime(2024, 3, 1, 12, tzinfo=UTC),
]
SINCE = np.array([4321.0])


@pytest.fixture(autouse=True)
def _no_downloads():
    with iers.conf.set_temp("auto_download", False):
        yield


@pytest.mark.parametrize("date", DATES)
def test_the_sun_is_where_astropy_says(date: datetime):
    now = Time(date) + SINCE[0] * u.s
    sun = get_sun(now).cartesian.xyz.value
    (ours,) = to_the_sun(date, SINCE)
    # Aberration, 0.0057 deg, which astropy has, and 0.01 deg of the short series.
    apart = np.degrees(np.arccos(ours @ sun / np.linalg.norm(sun)))
    assert apart < 0.016


@pytest.mark.parametrize("date", DATES)
def test_the_earth_has_turned_as_astropy_says(date: datetime):
    now = Time(date) + SINCE[0] * u.s
    x = GCRS(CartesianRepresentation(7000 * u.km, 0 * u.km, 0 * u.km), obstime=now)
    seen = x.transform_to(ITRS(obstime=now)).cartesian.xyz.value
    (turned,) = earth_turned(date, SINCE)
    off = np.arctan2(seen[1], seen[0]) + turned
    # UT1 is within 0.9 s of UTC: 15 arcsec a second.
    assert abs(np.degrees((off + np.pi) % (2 * np.pi) - np.pi)) < 0.9 * 15 / 3600
    # The axis moves by 20 arcsec a year.
    years = date.year + 1 - 2000
    assert abs(np.degrees(np.arcsin(seen[2] / 7000))) < 20.1 / 3600 * years


def test_the_earth_casts_a_shadow():
    sun = np.array([[1.0, 0.0, 0.0]])
    R = 7e6
    # Behind, at the horizon of the shadow's edge, and before it.
    edge = np.pi - np.arcsin(R_E / R)
    for angle, part in ((np.pi, 0.0), (edge + 5e-3, 0.0), (edge, 0.5), (1.6, 1.0)):
        r = R * np.array([[np.cos(angle), np.sin(angle), 0.0]])
        assert sunlit(r, sun)[0] == pytest.approx(part, abs=1e-9), angle
