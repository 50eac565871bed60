"""Orbits by orbit, against closed forms and another integrator."""

import numpy as np
import pytest
from leapfrog_orbit import leapfrog

from orbident.errors import InputError
from orbident.orbits import orbit
from orbident.orbits.earth import J2, MU, R_E
from orbident.orbits.orbit import Elements

ELLIPSE = Elements(8e6, 0.9, 0.15, node=0.4, perigee=1.1, anomaly=0.3)


def test_the_state_is_that_of_a_textbook():
    """Vallado, Fundamentals of Astrodynamics, Example 2-5."""
    at = np.radians([87.870, 227.898, 53.38, 92.335])
    i, node, perigee, anomaly = at
    x = Elements(36127.343e3, i, 0.832853, node, perigee, anomaly).state()
    # The perigee has two decimals: half of the last one is 9e-5 rad.
    r, v = [6524.834, 6862.875, 6448.296], [4.901327, 5.533756, -1.976341]
    np.testing.assert_allclose(x[:3] / 1e3, r, atol=9e-5 * float(np.linalg.norm(r)))
    np.testing.assert_allclose(x[3:] / 1e3, v, atol=9e-5 * float(np.linalg.norm(v)))


def kepler(orbit: Elements, t: np.ndarray) -> np.ndarray:
    """Places by Kepler's equation, solved by Newton's method."""
    a, e = orbit.semi_major_axis, orbit.eccentricity
    E_0 = 2 * np.arctan(np.sqrt((1 - e) / (1 + e)) * np.tan(orbit.anomaly / 2))
    M = E_0 - e * np.sin(E_0) + np.sqrt(MU / a**3) * t
    E = M.copy()
    for _ in range(20):
        E -= (E - e * np.sin(E) - M) / (1 - e * np.cos(E))
    x, y = a * (np.cos(E) - e), a * np.sqrt(1 - e**2) * np.sin(E)
    c, s = np.cos(orbit.perigee), np.sin(orbit.perigee)
    along, across = c * x - s * y, s * x + c * y
    ci, si = np.cos(orbit.inclination), np.sin(orbit.inclination)
    cn, sn = np.cos(orbit.node), np.sin(orbit.node)
    return np.stack(
        [cn * along - sn * ci * across, sn * along + cn * ci * across, si * across],
        axis=1,
    )


def test_a_round_earth_has_kepler_s_orbits(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(orbit, "J2", 0.0)
    t = np.linspace(-7000.0, 14000.0, 211)
    # Steps are exact to 1e-11; two turns amplify this by 3 n t = 40.
    np.testing.assert_allclose(
        ELLIPSE.states(t)[:, :3], kepler(ELLIPSE, t), atol=1e-9 * 8e6
    )


def test_an_oblate_earth_against_another_integrator():
    end = 6000.0
    x = ELLIPSE.states(np.array([0.0, end]))[-1]
    coarse, fine = (leapfrog(ELLIPSE.state(), end, n)[-1] for n in (500, 1000))
    # What the other one is off by is a fifteenth of what halving its step changes.
    expected = fine + (fine - coarse) / 15
    assert np.linalg.norm(x[:3] - expected[:3]) < 1e-2
    assert np.linalg.norm(x[3:] - expected[3:]) < 1e-5
    round_earth = kepler(ELLIPSE, np.array([end]))[0]
    assert np.linalg.norm(x[:3] - round_earth) > 1e4


def osculating(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Node and perigee of states, rad."""
    r, v = x[:, :3], x[:, 3:]
    h = np.cross(r, v)
    R = np.linalg.norm(r, axis=1, keepdims=True)
    e = np.cross(v, h) / MU - r / R
    to_node = np.cross([0.0, 0.0, 1.0], h)
    across = np.cross(h, to_node)
    across /= np.linalg.norm(h, axis=1, keepdims=True)
    perigee = np.arctan2(np.sum(e * across, axis=1), np.sum(e * to_node, axis=1))
    node = np.arctan2(to_node[:, 1], to_node[:, 0])
    return np.unwrap(node), np.unwrap(perigee)


def test_node_and_perigee_drift_as_j2_makes_them():
    """Secular rates of first order in J2, over a day."""
    a, e, i = ELLIPSE.semi_major_axis, ELLIPSE.eccentricity, ELLIPSE.inclination
    n = np.sqrt(MU / a**3)
    k = 1.5 * J2 * n * (R_E / (a * (1 - e**2))) ** 2
    t = np.arange(0.0, 86400.0, 30.0)
    node, perigee = osculating(ELLIPSE.states(t))
    # A straight line through a dozen turns; J2's second order is 1e-3 of its first,
    # and swings of 1e-3 rad are averaged against drifts of 0.06 rad and more.
    assert np.polyfit(t, node, 1)[0] == pytest.approx(-k * np.cos(i), rel=0.01)
    drift = k * (2 - 2.5 * np.sin(i) ** 2)
    assert np.polyfit(t, perigee, 1)[0] == pytest.approx(drift, rel=0.02)


def test_elements_hold_for_a_week():
    with pytest.raises(InputError, match="20486 days from its epoch"):
        ELLIPSE.check_covers(1.77e9, 1.77e9 + 10)
