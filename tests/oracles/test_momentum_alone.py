"""Recordings without positions, flown by MuJoCo: momentum shows `pi` alone.

pytest -m long -s tests/oracles/test_momentum_alone.py
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from acting_in_mujoco import Torque
from clean_recordings import SENSORS
from mujoco_flights import Flight
from random_motions import random_motion
from random_robots import DUAL_ARM, random_robot, random_wheels

from orbident.errors import InputError
from orbident.estimation.identify import identify
from orbident.estimation.result import Result
from orbident.identified.comparison import compare
from orbident.identified.validate import validate
from orbident.model.minimal_sets import minimal_sets
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.sensor_schema import declared_sensors

PARENTS = ((), (0,), (0, 1), (0, 1, 2), (0, 1, 0), (0, 1, 0, 3))
"""The parents of the joints of each robot; the first robot has no joint."""

OFF = 0.05
"""CAD masses and inertias are off by so much, those of each body by one factor."""

FAR = 4.5
"""Deviations: of ten thousand numbers none is so far off by chance."""


class Momentum(NamedTuple):
    """A flight, and what its user knows of the robot."""

    robot: Robot
    recording: Recording
    cad: Robot

    def identified(self) -> Result:
        """From momentum alone."""
        seen = self.recording.columns.items()
        columns = {name: x for name, x in seen if not name.startswith("position")}
        return identify(self.cad, replace(self.recording, columns=columns))

    def off(self, result: Result) -> np.ndarray:
        """Errors of `pi` over their deviations."""
        pi = minimal_sets(self.robot).pi(self.robot.theta)
        return (result.pi.values - pi) / result.pi.std


def flown(seed: int, parents: tuple[int, ...], loaded: float = 1.0) -> Momentum:
    """A random robot; its last body is so much heavier than in CAD."""
    wheels = random_wheels(seed, ("held",) * 3)
    sensors = declared_sensors({"rate": 20.0, **SENSORS})
    robot = random_robot(seed, parents, wheels=wheels, base=20.0)
    robot = replace(robot, sensors=sensors, disturbances={})
    factors = 1 + OFF * np.random.default_rng(seed).standard_normal(len(robot.bodies))
    cad = replace(robot, theta=factors[:, None] * robot.theta)
    theta = robot.theta.copy()
    theta[-1] *= loaded
    robot = replace(robot, theta=theta)
    motion = random_motion(robot, seed, 40.0, 100.0, "turning")
    flight = Flight(robot, motion, Torque(np.zeros(3)), breath=0.5)
    return Momentum(robot, flight.recorded(seed), cad)


@pytest.mark.slow
@pytest.mark.parametrize("parents", [(), (0, 1), DUAL_ARM])
def test_pi_is_identified(parents: tuple[int, ...]):
    """A satellite without an arm has its inertia about the CM."""
    flight = flown(1, parents)
    result = flight.identified()
    assert result.level == "with care"
    assert (np.abs(flight.off(result)) < FAR).all()
    assert np.isnan([result.mass.value, *result.base.values, *result.phi.values]).all()
    assert "pi alone" in repr(result)
    with pytest.raises(InputError, match=r"pi alone: .* record position"):
        result.dynamics()


@pytest.mark.slow
def test_it_is_what_positions_would_show():
    flight = flown(2, (0, 1, 2))
    alone, whole = flight.identified(), identify(flight.cad, flight.recording)
    both = [alone.pi.values, whole.pi.values]
    # With positions there is more to tell it by.
    assert (whole.pi.std <= 1.001 * alone.pi.std).all()
    assert (np.abs(np.subtract(*both)) < FAR * alone.pi.std).all()
    assert compare(alone, whole).of == "pi"
    assert compare(alone, whole).status == "no change"


@pytest.mark.slow
def test_a_load_changes_pi():
    empty, loaded = flown(2, (0, 1, 2)), flown(2, (0, 1, 2), loaded=2.0)
    alone = empty.identified()
    found = compare(alone, loaded.identified())
    assert (found.status, found.of, found.added) == ("changed", "pi", None)
    assert "record positions before and after" in found.warnings[-1]
    # What turns the base is predicted, and whether that is explained.
    same, other = (validate(alone, x.recording) for x in (empty, loaded))
    assert (same.verdict, other.verdict) == ("explained", "not explained")
    assert same.rms["gyro"] < 0.01 * other.rms["gyro"]
    assert np.isnan(same.rms["velocity"])
    blind = {k: x for k, x in empty.recording.columns.items() if k[:8] != "position"}
    again = validate(alone, replace(empty.recording, columns=blind))
    assert again.verdict == "explained"


@pytest.mark.slow
def test_beside_positions_it_counts():
    """The recording with positions has what it shows, whichever is given first."""
    flight = flown(2, (0, 1, 2))
    more = random_motion(flight.robot, 7, 40.0, 100.0, "turning")
    other = Flight(flight.robot, more, Torque(np.zeros(3))).recorded(7)
    columns = {k: x for k, x in other.columns.items() if not k.startswith("position")}
    other = replace(other, columns=columns)
    both = [identify(flight.cad, each) for each in ([flight.recording], [other])]
    one = identify(flight.cad, [flight.recording, other])
    again = identify(flight.cad, [other, flight.recording])
    beta = minimal_sets(flight.robot).beta(flight.robot.theta)
    assert (np.abs(one.base.values - beta) < FAR * one.base.std).all()
    assert (one.base.std < 1.001 * both[0].base.std).all()
    assert (one.pi.std < 1.001 * np.minimum(both[0].pi.std, both[1].pi.std)).all()
    np.testing.assert_allclose(again.base.values, one.base.values, rtol=1e-6)


@pytest.mark.slow
def test_another_robot_beside_positions_is_told():
    whole, loaded = flown(2, (0, 1, 2)), flown(2, (0, 1, 2), loaded=2.0)
    columns = loaded.recording.columns.items()
    blind = {k: x for k, x in columns if not k.startswith("position")}
    both = [whole.recording, replace(loaded.recording, columns=blind)]
    result = identify(whole.cad, both)
    assert result.status == "rejected"
    assert "do not show the same robot" in result.refusal()


@pytest.mark.slow
def test_wheels_that_stand_tell_no_size():
    """Noise of their encoders had made `pi` a millionth of what it is, with care."""
    flight = flown(1, (0, 1))
    still = {
        key: 2.5e-5 * np.random.default_rng(k).standard_normal(x.size)
        for k, (key, x) in enumerate(flight.recording.columns.items())
        if key.startswith("wheel")
    }
    columns = {**flight.recording.columns, **still}
    standing = replace(flight.recording, columns=columns)
    result = flight._replace(recording=standing).identified()
    assert result.refusal().startswith("pi has no scale")


@pytest.mark.long
def test_intervals_of_pi():
    """The 95 % intervals of sixty random robots hold the true `pi` as often as that."""
    inside = []
    for seed in range(60):
        flight = flown(seed, PARENTS[seed % len(PARENTS)])
        result = flight.identified()
        assert result.status == "ok", result.refusal()
        off = np.abs(flight.off(result))
        assert np.nanmax(off) < FAR
        inside.extend(off < 1.96)
    print(f"{len(inside)} of pi, {np.mean(inside):.1%} inside")
    assert 0.93 < np.mean(inside) < 0.97
