"""Rates of joints and wheels by tachometers whose noise is declared."""

import numpy as np
import pytest
from clean_recordings import clean_space

import orbident as oi
from orbident.preprocessing.histories import Histories, histories
from orbident.preprocessing.origins import Origin
from orbident.preprocessing.rate_noise import (
    RateNoise,
    least_speed_noise,
    rate_noise,
)
from orbident.preprocessing.screening import screened
from orbident.preprocessing.smoothing import Settings
from orbident.robot.sensor_schema import EncoderSpec

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


T = np.arange(601) / 20
"""s."""


def of_wheel(speed: np.ndarray, std: float, shows: float = 0.0) -> Histories:
    """What is made of a speed that a tachometer of this noise alone shows."""
    recording = oi.Recording(T, {"wheel.rw.speed": speed})
    sensor = EncoderSpec(tachometer=std)
    return histories(
        recording, "wheel", ["rw"], "speed", sensor, 0.0, Settings(), shows
    )


def test_a_speed_that_changes_slowly_is_smoothed():
    """What remains is less than the noise, and its waves have the density of all."""
    true, std = 100 + 10 * np.sin(2 * np.pi * T / T[-1]), 0.1
    read = true + std * np.random.default_rng(1).standard_normal(T.size)
    found = of_wheel(read, std)
    assert found.origin is Origin.SMOOTHED_RATES
    # Smoothing leaves a hundredth or two of the variance.
    assert np.std(found.rates[0] - true) < std / 4
    (noise,) = found.noise
    assert noise.density == pytest.approx(std * 0.05**0.5, rel=1e-2)
    assert noise.white == 0.0


def test_a_speed_with_corners_is_used_as_it_was_read():
    """A smoother would be off by many deviations of so little noise next to them."""
    rise = 100 + 20 * np.clip((T - 10) / 3, 0, 1)
    read = rise + 0.003 * np.random.default_rng(1).standard_normal(T.size)
    found = of_wheel(read, 0.003)
    assert found.origin is Origin.MEASURED
    np.testing.assert_array_equal(found.rates[0], read)
    assert found.noise[0].white == 0.003


def test_noise_that_the_gyro_hides_is_no_unknown(by_wheels):
    """What turns the base by half the gyro's noise is a part of that noise."""
    read = 100 + 0.1 * np.random.default_rng(1).standard_normal(T.size)
    found = of_wheel(read, 0.1, shows=0.03)
    assert found.origin is Origin.MEASURED
    assert found.noise[0] == RateNoise(0.0, 0.1)
    robot = by_wheels.robot
    loud = WHEELS * np.median(np.diff(by_wheels.recording.t)) ** 0.5
    assert least_speed_noise(robot) < loud
    noise = [RateNoise(0.0, least_speed_noise(robot))] * len(robot.wheels)
    assert rate_noise(robot, noise) == pytest.approx(robot.sensors.gyro.white_noise / 2)


@pytest.mark.parametrize("zero", [0.0, 157.3])
def test_a_speed_that_never_shows_its_noise_is_noted(by_wheels, zero: float):
    """A tachometer that repeats one number, or counts in steps beyond its noise."""
    robot, recording = by_wheels.robot, by_wheels.recording
    first, second, third = (f"wheel.{name}.speed" for name in robot.wheel_names)
    coarse = 30.0 * np.round(20.0 * np.sin(0.1 * recording.t) + 3.0)
    columns = {first: np.full(recording.t.size, zero), second: coarse}
    found = screened(robot, recording.with_columns(columns))
    stuck, steps = found.notes
    assert stuck.startswith(
        f"column '{first}' is {zero:g} rad/s throughout, without the declared noise"
    )
    assert steps.startswith(f"column '{second}' goes in steps of 30 rad/s, without")
    assert found.recording.has(first, second, third)


@pytest.mark.parametrize("step", [0.0, 1e-3, WHEELS])
@pytest.mark.parametrize("slope", [0.0, 10.0])
def test_noise_and_finer_steps_are_not_noted(by_wheels, step: float, slope: float):
    robot, recording = by_wheels.robot, by_wheels.recording
    columns = {
        name: step * np.round(x / step) if step else x
        for wheel in robot.wheel_names
        for name in [f"wheel.{wheel}.speed"]
        for x in [recording.columns[name] + slope * recording.t]
    }
    assert not screened(robot, recording.with_columns(columns)).notes
