"""The sizes and directions of what acts in an orbit, worked out by hand."""

import numpy as np

from orbident.environment.agent import Agent, World
from orbident.environment.motion import Load, at_rest
from orbident.environment.orbital import (
    MagneticDipole,
    OrbitalDrag,
    SunlightPressure,
)
from orbident.orbits.orbit import Elements, Orbit
from orbident.robot.robot_file import load_robot
from orbident.trajectories.environment import Environment

ROBOT = load_robot("dual-arm")
EQUATOR = Orbit(Elements(6778137.0, 0.0)).arc(0.0, 1.0)


def acting(agent: Agent, **what) -> Load:
    """What acts of it alone on the robot at rest, above the equator."""
    orbit = {"altitude": "400 km", "inclination": 0}
    given = Environment.model_validate({"orbit": orbit, **what})
    (load,) = agent.loads(World(given, EQUATOR), at_rest(ROBOT, np.zeros(3)))
    return load


def moment_about_S(load: Load) -> np.ndarray:
    return load.moment[0, 0] + np.cross(load.point, load.force[0, 0])


def test_air_drag_at_400_km_is_a_millinewton_metre():
    """3e-12 kg/m^3, 10 m^2 and an arm of 0.5 m."""
    x, y, z = ROBOT.feature_point
    air = {"density": 3e-12, "area": 10, "centre": [x + 0.5, y, z]}
    load = acting(OrbitalDrag(), air_drag=air)
    # The air turns with the Earth: 494 m/s at that height.
    force = -0.5 * 3e-12 * 2.2 * 10 * (7680.0 - 494.3) ** 2
    np.testing.assert_allclose(load.force[0, 0], [0, force, 0], rtol=5e-3, atol=1e-12)
    np.testing.assert_allclose(
        moment_about_S(load), [0, 0, 0.5 * force], rtol=5e-3, atol=1e-12
    )
    assert 0.5e-3 < -0.5 * force < 1.5e-3


def test_sunlight_pushes_away_from_the_sun():
    sun = {"sun": [0, 0, 3], "area": 2, "coefficient": 1, "centre": [0, 0, 0]}
    load = acting(SunlightPressure(), solar_pressure=sun)
    np.testing.assert_allclose(load.force[0, 0], [0, 0, -2 * 4.54e-6])
    expected = np.cross(-ROBOT.feature_point, load.force[0, 0])
    np.testing.assert_allclose(moment_about_S(load), expected)


def test_a_magnet_turns_towards_north():
    load = acting(MagneticDipole(), dipole=[5.0, 0.0, 0.0])
    # x towards z, by a turn about -y.
    size = 5 * 2.98e-5 * (6378.137 / 6778.137) ** 3
    np.testing.assert_allclose(load.moment[0, 0], [0, -size, 0], rtol=1e-9, atol=1e-18)
    assert not load.force.any()
