"""Arcs of orbits: directions, and states between the grid's times."""

from datetime import UTC, datetime

import numpy as np
import pytest

from orbident.errors import InputError
from orbident.orbits.orbit import Elements, Orbit

R = 6778137.0


def test_a_circle_begins_above_its_node_and_goes_east():
    arc = Orbit(Elements(R, 0.0)).arc(0.0, 1500.0)
    # A quarter of 92.6 minutes.
    start, later = arc.position(np.array([0.0, 1388.0]))
    np.testing.assert_allclose(start, [R, 0, 0], atol=1e-6)
    np.testing.assert_allclose(later / R, [0, 1, 0], atol=5e-3)
    # The air turns with the Earth: 494 m/s at that height.
    np.testing.assert_allclose(
        arc.wind(np.zeros(1)), [[0, 7668.56 - 494.27, 0]], atol=0.01
    )


def test_a_polar_orbit_goes_over_the_pole():
    arc = Orbit(Elements(R, np.pi / 2)).arc(0.0, 1500.0)
    _, later = arc.position(np.array([0.0, 1388.0]))
    np.testing.assert_allclose(later / R, [0, 0, 1], atol=5e-3)


def test_an_arc_is_exact_between_its_grid_points():
    orbit = Elements(7e6, 1.0, 0.02, perigee=0.5)
    t = np.linspace(-100.0, 3000.0, 1003)
    x, arc = orbit.states(t), Orbit(orbit).arc(-100.0, 3000.0)
    # Ten seconds are 0.011 rad: 0.011^4 / 384 of the radius, a third of a millimetre.
    np.testing.assert_allclose(arc.position(t), x[:, :3], atol=1e-3)
    wind = x[:, 3:] - np.cross([0, 0, 7.2921159e-5], x[:, :3])
    np.testing.assert_allclose(arc.wind(t), wind, atol=1e-3)


def test_without_a_date_nobody_knows_the_sun():
    arc = Orbit(Elements(R, 0.0)).arc(0.0, 10.0)
    with pytest.raises(InputError, match="add epoch: to the orbit"):
        arc.sun(np.zeros(1))


def test_the_sun_goes_down():
    """Of an orbit at 400 km through the sun's direction, 36.1 minutes of 92.6."""
    noon = datetime(2024, 3, 20, 12, tzinfo=UTC)
    t = np.arange(0.0, 5553.0)
    arc = Orbit(Elements(R, 0.0), noon).arc(0.0, 5553.0)
    light = np.linalg.norm(arc.sun(t), axis=1)
    shadow = np.arcsin(6378137.0 / R) / np.pi
    assert light.max() == pytest.approx(1.0)
    assert np.mean(1 - light) == pytest.approx(shadow, abs=2e-3)


def test_times_in_another_unit_take_no_memory():
    """A state every ten seconds would be 745 GiB."""
    with pytest.raises(InputError, match="elements hold for a week"):
        Orbit(Elements(R, 0.0)).arc(0.0, 1e12)
