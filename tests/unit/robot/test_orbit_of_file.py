"""The orbit and the torquers of a robot file."""

from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from ephemeris_files import write_oem

from orbident.errors import InputError
from orbident.orbits.orbit import Elements, Ephemeris
from orbident.robot.robot_file import load_robot, write_robot

EPOCH = datetime(2026, 3, 1, 12, tzinfo=UTC)


def motion(load_yaml, orbit: str) -> Elements:
    found = load_yaml(f"orbit: {{{orbit}}}").orbit
    assert found is not None
    assert isinstance(found.motion, Elements)
    return found.motion


def test_a_circle(load_yaml):
    found = motion(load_yaml, "altitude: 400 km, inclination: 51.6 deg")
    assert found == Elements(6778137.0, np.radians(51.6))


def test_an_ellipse(load_yaml):
    given = "semi_major_axis: 7000 km, eccentricity: 0.02, inclination: 90 deg, "
    given += "node: 0.1 rad, perigee: 30 deg, "
    found = motion(load_yaml, given + "anomaly: 15 deg")
    assert (found.semi_major_axis, found.eccentricity, found.node) == (7e6, 0.02, 0.1)
    assert found.perigee == pytest.approx(np.pi / 6)
    assert found.anomaly == pytest.approx(np.pi / 12)
    # The argument of latitude is from the node, and the anomaly from the perigee.
    again = motion(load_yaml, given + "argument: 45 deg")
    assert again.anomaly == pytest.approx(np.pi / 12)


@pytest.mark.parametrize(
    "text",
    [
        "2026-03-01T12:00:00Z",
        "2026-03-01T12:00",
        "2026-03-01 13:00:00+01:00",
    ],
)
def test_an_epoch_is_utc(load_yaml, text: str):
    lines = f"orbit: {{altitude: 500 km, inclination: 0, epoch: '{text}'}}"
    assert load_yaml(lines).orbit.epoch == EPOCH


def test_an_oem_is_kept_with_the_robot(load_yaml, tmp_path: Path):
    t = np.arange(0.0, 601.0, 60.0)
    states = Elements(6.8e6, 0.9).states(t)
    write_oem(tmp_path / "flight.oem", EPOCH, t, states)
    robot = load_yaml("orbit: {oem: flight.oem, epoch: 2026-03-01T12:00:00Z}")
    again = load_robot(write_robot(robot, tmp_path / "kept"))
    for each in (robot, again):
        assert each.orbit is not None
        assert each.orbit.epoch == EPOCH
        assert isinstance(each.orbit.motion, Ephemeris)
        np.testing.assert_allclose(each.orbit.motion.states, states, rtol=1e-9)


def test_torquers(load_yaml):
    lines = "torquers: [{name: mx, axis: [2, 0, 0]}, {name: my, axis: [0, 1, 0], "
    first, second = load_yaml(lines + "gain: 1 %}]").torquers
    np.testing.assert_array_equal(first.axis, [1, 0, 0])
    assert (first.gain, second.gain) == (0.1, 0.01)


WRONG = {
    "below the ground": ("altitude: -1 km, inclination: 0", "is below the ground"),
    "a low perigee": (
        "semi_major_axis: 7000 km, eccentricity: 0.1, inclination: 0, perigee: 0",
        "the orbit is below the ground: its perigee is 78.14 km below the equator's",
    ),
    "kilometres for metres": (
        "semi_major_axis: 7000 m, inclination: 0",
        "the orbit is below the ground",
    ),
    "no unit": ("altitude: 400, inclination: 0", "found 400; it has no unit; add"),
    "no unit of text": (
        'altitude: 400 km, inclination: "51.6"',
        "it has no unit; add one of rad, mrad, urad, deg",
    ),
    "another unit": ("altitude: 400 deg, inclination: 0", "unknown unit 'deg'"),
    "unknown key": ("altitude: 400 km, inclinatoin: 0", "unknown key 'inclinatoin'"),
    "no inclination": ("altitude: 400 km", "inclination: this key is missing"),
    "no size": ("inclination: 0", "give one of 'altitude', of a circular orbit, and"),
    "two sizes": (
        "altitude: 400 km, semi_major_axis: 7000 km, inclination: 0",
        "give one of 'altitude'",
    ),
    "a parabola": (
        "semi_major_axis: 7000 km, eccentricity: 1, inclination: 0",
        "less than 1 for an ellipse",
    ),
    "an ellipse by its altitude": (
        "altitude: 400 km, eccentricity: 0.01, inclination: 0",
        "give 'semi_major_axis' for an ellipse",
    ),
    "an ellipse without perigee": (
        "semi_major_axis: 7000 km, eccentricity: 0.01, inclination: 0",
        "an ellipse needs 'perigee'",
    ),
    "two places": (
        "altitude: 400 km, inclination: 0, argument: 1 rad, anomaly: 1 rad",
        "keep one",
    ),
    "no date": (
        "altitude: 400 km, inclination: 0, epoch: yesterday",
        "orbit.epoch: found 'yesterday'; give a date and time in UTC, such as 2026-",
    ),
    "a month too many": (
        "altitude: 400 km, inclination: 0, epoch: 2026-13-01",
        "give a date and time in UTC",
    ),
    "OEM without epoch": ("oem: flight.oem", "'oem' needs 'epoch'"),
    "OEM and elements": (
        "oem: flight.oem, altitude: 400 km, epoch: 2026-03-01",
        "'oem' and 'altitude' exclude each other",
    ),
    "no such OEM": (
        "oem: flight.oem, epoch: 2026-03-01",
        "flight.oem: no such file; check the path",
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_is_no_orbit_is_one_line(load_yaml, case: str):
    orbit, words = WRONG[case]
    with pytest.raises(InputError) as refused:
        load_yaml(f"orbit: {{{orbit}}}")
    message = str(refused.value)
    assert words in message
    assert "servicer.yaml:3: orbit" in message or "flight.oem: " in message
    assert "\n" not in message


def test_a_table_is_not_in_orbit(load_yaml):
    with pytest.raises(InputError, match="orbit: a robot whose motion is planar"):
        load_yaml("motion: planar\norbit: {altitude: 400 km, inclination: 0}")
