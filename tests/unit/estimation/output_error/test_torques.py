"""Torques as means over shooting intervals: which count, and how much."""

from dataclasses import replace

import numpy as np
import pytest
from random_robots import random_robot

from orbident.errors import InputError
from orbident.estimation.output_error.problem import SENSORS
from orbident.estimation.output_error.sensors import Sensors, sensors_of
from orbident.estimation.output_error.shooting import Intervals, intervals_of
from orbident.estimation.output_error.torques import (
    MeanTorques,
    drives_of,
    joints_driven,
    mean_torques,
)
from orbident.estimation.unknowns import CalibrationFit
from orbident.preprocessing.samples import Samples, samples_of
from orbident.preprocessing.wrenches import RecordedWrench
from orbident.recordings.recording import Recording
from orbident.robot.description import Coupling, Friction, GearedRotor, Robot
from orbident.robot.sensor_schema import declared_sensors

DT, STD = 0.05, 0.2
T = np.arange(401) * DT

RATE = np.array([0.5, 0.8, 1.1])
"""rad/s: of what the joints do."""


def recording_of(robot: Robot, **changed: np.ndarray) -> Recording:
    """Joints on sines, with torques that are polynomials and a sign."""
    columns = {f"gyro.{k}": 0.1 * np.sin(T) for k in "xyz"}
    columns |= {f"attitude.{k}": 0 * T + (k == "w") for k in "xyzw"}
    for k, name in enumerate(robot.joint_names):
        columns[f"joint.{name}.position"] = np.sin(RATE[k] * T)
        columns[f"joint.{name}.velocity"] = RATE[k] * np.cos(RATE[k] * T)
        columns[f"joint.{name}.torque"] = 0.01 * T**2 + k + 1.0
    return Recording(T, columns | changed)


class Case:
    """A recording, cut into intervals."""

    def __init__(self, robot: Robot, recording: Recording):
        self.robot = robot
        self.samples: Samples = samples_of(robot, recording)
        late = dict.fromkeys(SENSORS, 0.0)
        self.sensors: Sensors = sensors_of(robot, recording, late)
        self.intervals: Intervals = intervals_of(robot, self.samples, self.sensors)

    def means(self) -> MeanTorques:
        return mean_torques(self.robot, self.samples, self.sensors, self.intervals)

    def counts(self) -> np.ndarray:
        """Of each interval and joint."""
        return self.means().weights[self.intervals.edges[:-1]] > 0


@pytest.fixture(scope="module")
def robot() -> Robot:
    sensors = declared_sensors({"torques": {"std": STD}, "joints": {"position": 1e-4}})
    return replace(random_robot(5, (0, 1, 2)), sensors=sensors)


def test_means_and_their_weights(robot):
    case = Case(robot, recording_of(robot))
    found, edges = case.means(), case.intervals.edges
    start, stop = case.intervals.boundaries[:-1], case.intervals.boundaries[1:]
    first = edges[:-1]
    mean = 0.01 * (stop**3 - start**3) / 3 / (stop - start)
    for k in range(3):
        np.testing.assert_allclose(found.values[first, k], mean + k + 1.0, rtol=1e-9)
    weights = np.sqrt((stop - start) / DT) / STD
    np.testing.assert_allclose(found.weights[first], np.tile(weights, (3, 1)).T)
    # What changes them in a second; and where a rate changes its sign, part of it.
    np.testing.assert_allclose(
        found.over_intervals[:, 0, 1], 0.01 * (start + stop), rtol=1e-9
    )
    signs = found.over_intervals[..., 0]
    assert np.isclose(np.abs(signs), 1.0, atol=0.05).any()
    assert (np.abs(signs) < 0.9).any()
    elsewhere = np.setdiff1d(np.arange(T.size), first)
    assert not found.weights[elsewhere].any()


def test_a_joint_that_stands_does_not_count(robot):
    """Its brake holds it from 8 to 12 s."""
    name = robot.joint_names[1]
    stands = (T > 8) & (T < 12)
    q, qd = np.sin(RATE[1] * T), RATE[1] * np.cos(RATE[1] * T)
    columns = {
        f"joint.{name}.position": np.where(stands, np.sin(RATE[1] * 8), q),
        f"joint.{name}.velocity": np.where(stands, 0.0, qd),
    }
    case = Case(robot, recording_of(robot, **columns))
    counts, bounds = case.counts(), case.intervals.boundaries
    inside = (bounds[:-1] > 8) & (bounds[1:] < 12)
    assert inside.any()
    assert not counts[inside, 1].any()
    assert counts[:, [0, 2]].all()
    assert counts[~inside, 1].any()


def test_gaps_and_pushes_do_not_count(robot):
    name = f"joint.{robot.joint_names[0]}.torque"
    torque = recording_of(robot).column(name).copy()
    torque[(T > 5) & (T < 9)] = np.nan
    case = Case(robot, recording_of(robot, **{name: torque}))
    case.samples = replace(case.samples, pushed=(12.0, 12.1))
    bounds = case.intervals.boundaries
    gap = (bounds[:-1] > 5) & (bounds[1:] < 9)
    pushed = (bounds[:-1] < 12.1) & (bounds[1:] > 12)
    counts = case.counts()
    assert gap.any()
    assert pushed.any()
    assert not counts[gap | pushed].any()
    assert counts[(bounds[1:] < 4)].all()


def test_joints_that_something_else_moves_do_not_count(robot):
    one, two, three = robot.joint_names
    case = Case(robot, recording_of(robot))
    case.robot = replace(robot, couplings=(Coupling(one, two, 1.0, 0.0),))
    assert joints_driven(case.robot, case.means().weights) == (f"joint.{three}.torque",)
    case.robot = robot
    case.samples = replace(case.samples, locked=(three,))
    assert joints_driven(robot, case.means().weights) == (
        f"joint.{one}.torque",
        f"joint.{two}.torque",
    )


def test_thrust_is_refused(robot):
    case, none = Case(robot, recording_of(robot)), np.zeros((4, 3))
    thrust = RecordedWrench("thruster", 0.0, none + 1.0, none, none)
    case.samples = replace(case.samples, wrenches=(thrust,))
    with pytest.raises(InputError, match="joint torques were recorded, and thrust"):
        case.means()


def test_what_drives_are_is_declared_and_found(robot):
    one, two, _ = robot.joint_names
    declared = replace(
        robot,
        rotors={one: GearedRotor(10.0, 0.01)},
        friction={one: Friction(1.0, 2.0, 3.0)},
    )
    errors = {f"joint.{one}.coulomb": CalibrationFit(0.5, 0.1, np.nan)}
    found = drives_of(declared, errors, [f"joint.{one}.torque"])
    assert {*found} == {one}
    assert found[one] == pytest.approx((0.9, 0.0, 1.0, 0.0, 2.5, 0.1, 3.0, 0.0))
    assert two not in found
