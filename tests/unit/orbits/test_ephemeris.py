"""OEM files, written and interpolated by the library that reads them."""

from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from astropy.time import Time, TimeDelta
from ephemeris_files import write_oem

from orbident.errors import InputError
from orbident.orbits.orbit import Elements, Orbit, read_oem

EPOCH = datetime(2024, 3, 1, 12, tzinfo=UTC)
T = np.arange(-60.0, 1260.1, 60.0)
STATES = Elements(6.8e6, 0.9, 0.01, perigee=0.3).states(T)


@pytest.mark.parametrize("kind", ["kvn", "xml"])
@pytest.mark.parametrize("system", ["UTC", "TAI", "TT"])
def test_it_says_what_its_own_reader_says(tmp_path: Path, kind: str, system: str):
    path = tmp_path / "flight.oem"
    theirs = write_oem(path, EPOCH, T, STATES, kind, TIME_SYSTEM=system)
    ours = Orbit(read_oem(path, EPOCH), EPOCH).arc(0.0, 1200.0)
    zero = getattr(Time(EPOCH, scale="utc"), system.lower())
    t = np.array([0.0, 17.0, 600.0, 1199.5])
    expected = [
        1e3 * theirs(zero + TimeDelta(each, format="sec")).position for each in t
    ]
    # Cubics through states a minute apart: 0.068^4 / 384 of the radius.
    np.testing.assert_allclose(ours.position(t), expected, atol=0.5)


def test_it_is_the_orbit_that_it_was_written_from(tmp_path: Path):
    path = tmp_path / "flight.oem"
    write_oem(path, EPOCH, T, STATES)
    found = Orbit(read_oem(path, EPOCH), EPOCH).arc(0.0, 1200.0)
    t = np.linspace(0.0, 1200.0, 333)
    expected = Orbit(Elements(6.8e6, 0.9, 0.01, perigee=0.3), EPOCH).arc(0.0, 1200.0)
    np.testing.assert_allclose(found.position(t), expected.position(t), atol=0.5)
    np.testing.assert_allclose(found.wind(t), expected.wind(t), atol=0.05)


@pytest.mark.parametrize(
    ("metadata", "words"),
    [
        ({"REF_FRAME": "ITRF"}, "REF_FRAME: found 'ITRF'; give an OEM with one of"),
        ({"CENTER_NAME": "MARS"}, "CENTER_NAME: found 'MARS'"),
        ({"TIME_SYSTEM": "TDB"}, "TIME_SYSTEM: found 'TDB'"),
    ],
)
def test_another_frame_is_refused(tmp_path: Path, metadata: dict, words: str):
    path = tmp_path / "flight.oem"
    write_oem(path, EPOCH, T, STATES, **metadata)
    with pytest.raises(InputError, match=words):
        read_oem(path, EPOCH)


def test_it_must_cover_what_is_asked_for(tmp_path: Path):
    path = tmp_path / "flight.oem"
    write_oem(path, EPOCH, T, STATES)
    words = "has states from t = -60 to 1260 s .* and the recording is from 0 to 2000 s"
    with pytest.raises(InputError, match=words):
        Orbit(read_oem(path, EPOCH), EPOCH).arc(0.0, 2000.0)


def test_it_must_not_have_a_gap(tmp_path: Path):
    path = tmp_path / "flight.oem"
    write_oem(path, EPOCH, T[[0, 1, -2, -1]], STATES[[0, 1, -2, -1]])
    with pytest.raises(InputError, match="no state between t = 0 and 1200 s"):
        Orbit(read_oem(path, EPOCH), EPOCH).arc(0.0, 100.0)


def test_metres_are_refused(tmp_path: Path):
    path = tmp_path / "flight.oem"
    write_oem(path, EPOCH, T, STATES / 1e6)
    with pytest.raises(InputError, match="an orbit below the ground; give kilometres"):
        read_oem(path, EPOCH)


@pytest.mark.parametrize(
    "text", ["", "CCSDS_OEM_VERS = 2.0\n", "t,x\n0,1\n", "<oem/>", "\x00\x01"]
)
def test_what_is_no_oem_is_one_line(tmp_path: Path, text: str):
    path = tmp_path / "flight.oem"
    path.write_text(text)
    with pytest.raises(InputError, match=r"flight\.oem: no valid OEM") as refused:
        read_oem(path, EPOCH)
    assert "\n" not in str(refused.value)
