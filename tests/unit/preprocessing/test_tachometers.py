"""Rates of joints and wheels by tachometers whose noise is declared."""

import numpy as np
import pytest
from clean_recordings import clean_space

import orbident as oi

JOINTS, WHEELS = 1e-3, 0.05
"""rad/s."""


@pytest.fixture(scope="module")
def by_joints():
    joints = {"position": 2.5e-5, "tachometer": JOINTS}
    return clean_space(seed=3, joints=joints)


@pytest.fixture(scope="module")
def by_wheels():
    return clean_space(seed=3, wheels={"tachometer": WHEELS})


def test_a_simulation_has_the_rates_that_are_declared(by_joints, by_wheels):
    assert by_joints.recording.has("joint.joint1.velocity", "joint.joint1.position")
    wheel = by_wheels.robot.wheel_names[0]
    assert by_wheels.recording.has(f"wheel.{wheel}.speed")
    assert not by_wheels.recording.has(f"wheel.{wheel}.position")


def test_noise_of_joint_rates_does_not_show_in_the_other_sensors(by_joints):
    result = oi.identify(by_joints.robot, by_joints.recording)
    assert result.level == "trust", result.warnings
    gyro = result.residual.get("sensors", {})["gyro"]
    assert gyro["noise"] == pytest.approx(gyro["declared"], rel=0.1)
    assert np.abs(by_joints.z(result)).max() < 4


def test_noise_of_wheel_speeds_does_not_show_in_the_gyro(by_wheels):
    result = oi.identify(by_wheels.robot, by_wheels.recording)
    assert result.level == "trust", result.warnings
    assert result.origins["wheel_speeds"] == "derived: smoothed rates"
    gyro = result.residual.get("sensors", {})["gyro"]
    assert gyro["declared"] == pytest.approx(by_wheels.gyro_std)
    assert gyro["noise"] == pytest.approx(gyro["declared"], rel=0.1)
    assert np.abs(by_wheels.z(result)).max() < 4
    # It is neither something from outside nor a free number.
    assert not result.disturbances
    assert not result.allowed
    assert result.widened_by == 1.0
