"""A magnetic torquer in the field of an orbit: it gives the scale without any wheel.

The torque is that of the simulator's magnet, which is in the base and always on.
"""

from dataclasses import replace

import numpy as np
import pytest
from random_robots import random_robot

from orbident.errors import InputError
from orbident.estimation.identify import identify
from orbident.model.minimal_sets import minimal_sets
from orbident.orbits.orbit import Elements, Orbit
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot, Torquer
from orbident.robot.sensor_schema import declared_sensors
from orbident.simulation.measure import measure_truth
from orbident.simulation.simulate import Made, made_along
from orbident.trajectories.environment import Environment
from orbident.trajectories.trajectory import Trajectory

RATE, DURATION = 10.0, 60.0
"""Hz and s."""

DIPOLE = {"mx": 300.0, "mz": 200.0}
"""As commanded, A m^2: much, so that a minute is enough."""

GAIN = 1.07
"""The true dipole of `mz`, over that which is recorded."""


@pytest.fixture(scope="module")
def robot() -> Robot:
    """No wheel; one torquer is calibrated, the other to a tenth."""
    x, _, z = np.eye(3)
    sensors = {
        "rate": RATE,
        "gyro": {"angle_random_walk": 2e-6},
        "joints": {"position": 2e-5},
        "attitude": {"angle": 1e-4},
        "position": {"std": 2e-4},
    }
    return replace(
        random_robot(11, (0, 1), base=10.0),
        torquers=(Torquer("mx", x, 0.0), Torquer("mz", z, 0.1)),
        orbit=Orbit(Elements(6778137.0, 0.9)),
        sensors=declared_sensors(sensors),
    )


@pytest.fixture(scope="module")
def made(robot: Robot) -> Made:
    acts = {
        "gravity_gradient": True,
        "dipole": [DIPOLE["mx"], 0.0, GAIN * DIPOLE["mz"]],
    }
    rest = np.zeros((2, 3))
    trajectory = Trajectory(
        duration=DURATION,
        joints=robot.joint_names,
        a=np.array([[0.2, -0.1], [0.15, 0.2]]),
        b=np.array([[0.1, 0.3], [-0.2, 0.2]]),
        start=rest,
        end=rest,
        environment=Environment.model_validate(acts),
    )
    return made_along(robot, trajectory, RATE)


def recorded(robot: Robot, made: Made, seed: int) -> Recording:
    """The sensors, the field, and what the torquers were asked for."""
    seen = measure_truth(robot, made.t, made.true, seed)
    asked = {f"torquer.{n}.dipole": np.full(seen.t.size, m) for n, m in DIPOLE.items()}
    return seen.with_columns({**made.known, **asked})


@pytest.mark.parametrize("seed", range(2))
def test_without_wheels(robot: Robot, made: Made, seed: int):
    """All parameters, the mass, and the torquer that is not known."""
    result = identify(robot, recorded(robot, made, seed))
    assert result.status == "ok", result.warnings
    z = (result.base.values - minimal_sets(robot).beta(robot.theta)) / result.base.std
    assert np.isfinite(z).all()
    assert np.abs(z).max() < 4
    assert result.mass.std < 0.05 * robot.mass
    gain = result.calibration["torquer.mz.gain"]
    assert abs(gain.value - (GAIN - 1)) < 4 * gain.std < 0.1
    assert not result.disturbances


def test_a_torquer_needs_the_field(robot: Robot, made: Made):
    seen = recorded(robot, made, 0)
    columns = {n: x for n, x in seen.columns.items() if not n.startswith("field")}
    words = r"column 'torquer\.mx\.dipole': without the magnetic field .*add columns f"
    # An orbit without a date knows no field.
    with pytest.raises(InputError, match=words):
        identify(robot, replace(seen, columns=columns))


def test_there_is_no_such_torquer(robot: Robot, made: Made):
    seen = recorded(robot, made, 0)
    other = {"torquer.my.dipole": np.ones(seen.t.size)}
    with pytest.raises(InputError, match="no torquer 'my', only 'mx', 'mz'; rename"):
        identify(robot, seen.with_columns(other))
