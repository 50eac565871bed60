"""What output error reads of a recording: times, gaps, noise."""

from dataclasses import replace

import numpy as np
import pytest

import orbident as oi
from orbident.estimation.output_error.sensors import sensors_of
from orbident.gaussian import noisiest_std
from orbident.preprocessing.delays import delays
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.sensor_schema import SensorsSpec, declared_sensors

T = np.arange(200) * 0.05


@pytest.fixture(scope="module")
def robot() -> Robot:
    return replace(oi.load_robot("paper-spatial"), sensors=SensorsSpec())


def recording(random: np.random.Generator, noise: float = 0.0) -> Recording:
    names = [f"joint.joint{k}.position" for k in (1, 2, 3)]
    names += [f"{sensor}.{k}" for sensor in ("gyro", "velocity") for k in "xyz"]
    columns = {
        name: np.sin(0.3 * T + k) + noise * random.standard_normal(T.size)
        for k, name in enumerate(names)
    }
    attitude = {"attitude.z": np.sin(0.1 * T), "attitude.w": np.cos(0.1 * T)}
    none = {"attitude.x": 0 * T, "attitude.y": 0 * T}
    return Recording(T, {**columns, **attitude, **none})


def read(robot: Robot, recording: Recording, sensors=None):
    robot = replace(robot, sensors=declared_sensors(sensors or {}))
    return sensors_of(robot, recording, delays(robot, recording, {}))


def holes(recording: Recording, sensor: str, seen: np.ndarray) -> Recording:
    columns = {
        name: np.where(seen, column, np.nan) if name.startswith(sensor) else column
        for name, column in recording.columns.items()
    }
    return Recording(recording.t, columns)


def test_sensors_and_their_axes(robot):
    found = read(robot, recording(np.random.default_rng(0)))
    np.testing.assert_array_equal(found.t, T)
    axes = {name: each.values.shape for name, each in found.by_name.items()}
    assert axes == {
        "attitude": (200, 4),
        "gyro": (200, 3),
        "joints": (200, 3),
        "velocity": (200, 3),
    }


def test_measured_joint_rates_leave_no_correction(robot):
    """Where one joint's rate was measured, histories are taken as they are."""
    plain = recording(np.random.default_rng(0))
    with_rate = {**plain.columns, "joint.joint2.velocity": np.cos(T)}
    assert "joints" not in read(robot, Recording(T, with_rate)).by_name


def test_slower_sensors_and_gaps(robot):
    """A row counts for a sensor only where all its axes have a sample."""
    every = np.arange(T.size) % 4 == 0
    slow = holes(recording(np.random.default_rng(0)), "velocity", every)
    slow = holes(slow, "gyro.y", np.arange(T.size) != 7)
    found = read(robot, slow)
    velocity, gyro = (found.by_name[name].values for name in ("velocity", "gyro"))
    np.testing.assert_array_equal(np.isfinite(velocity).all(axis=1), every)
    np.testing.assert_array_equal(velocity[every, 0], slow.columns["velocity.x"][every])
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(gyro[:, 0])), [7])


def test_a_sensor_without_samples_is_not_there(robot):
    silent = holes(recording(np.random.default_rng(0)), "velocity", T < 0)
    assert "velocity" not in read(robot, silent).by_name


def test_a_quaternion_may_have_either_sign(robot):
    """As trackers give it; a jump to the other side is no noise of 1 rad."""
    plain = recording(np.random.default_rng(0))
    signs = np.random.default_rng(1).choice([-1.0, 1.0], T.size)
    columns = {
        name: signs * x if name.startswith("attitude") else x
        for name, x in plain.columns.items()
    }
    one = read(robot, plain).by_name["attitude"]
    other = read(robot, Recording(T, columns)).by_name["attitude"]
    assert (other.std, other.least) == (one.std, one.least)
    np.testing.assert_array_equal(other.values, signs[0] * one.values)


def test_latencies_move_the_samples(robot):
    """Each at the time at which it saw the world, on the gyro's clock."""
    late = {"gyro": {"latency": 0.02}, "attitude": {"angle": 0.0, "latency": 0.03}}
    plain = recording(np.random.default_rng(0))
    found = read(robot, plain, late)
    gyro, attitude = (found.by_name[name].values for name in ("gyro", "attitude"))
    at_gyro, at_attitude = (np.isfinite(x[:, 0]) for x in (gyro, attitude))
    np.testing.assert_allclose(found.t[at_gyro], T)
    np.testing.assert_allclose(found.t[at_attitude], T - 0.01)
    np.testing.assert_array_equal(gyro[at_gyro, 0], plain.columns["gyro.x"])
    assert not (at_gyro & at_attitude).any()


def test_a_latency_of_whole_rows_meets_the_other_rows(robot):
    """Rows that differ by rounding alone are one row."""
    found = read(
        robot,
        recording(np.random.default_rng(0)),
        {"joints": {"position": 0.0, "latency": 0.15}},
    )
    assert found.t.size == T.size + 3
    assert np.diff(found.t).min() > 0.049
    joints, gyro = (found.by_name[name].values for name in ("joints", "gyro"))
    both = np.isfinite(joints[:, 0]) & np.isfinite(gyro[:, 0])
    assert np.count_nonzero(both) == T.size - 3


def test_declared_noise(robot):
    sensors = {
        "gyro": {"angle_random_walk": 1e-3, "bias_instability": 1e-4},
        "attitude": {"angle": 2e-3},
        "joints": {"position": 3e-4, "resolution": 4e-4},
    }
    found = read(robot, recording(np.random.default_rng(0)), sensors).by_name
    # White noise of density N, sampled at 20 Hz.
    assert found["gyro"].std == pytest.approx(1e-3 * np.sqrt(20))
    assert found["gyro"].drift > 0
    assert found["attitude"].std == 2e-3
    # A uniform error of one count beside the rest.
    assert found["joints"].std == pytest.approx(np.hypot(3e-4, 4e-4 / np.sqrt(12)))
    declared = {name: each.declared for name, each in found.items()}
    assert declared == dict.fromkeys(("attitude", "gyro", "joints"), True) | {
        "velocity": False
    }


def test_undeclared_noise_is_the_samples_scatter(robot):
    found = read(robot, recording(np.random.default_rng(0), noise=1e-3)).by_name
    # The median of 600 numbers is good to 5 %.
    assert found["velocity"].std == pytest.approx(1e-3, rel=0.15)
    assert not found["velocity"].declared


def test_scatter_sees_noise_and_no_motion():
    random = np.random.default_rng(0)
    noise = 0.01 * random.standard_normal((20000, 2))
    t = np.arange(20000)[:, None] * 0.05
    assert noisiest_std(noise) == pytest.approx(0.01, rel=0.03)
    assert noisiest_std(noise + np.sin(t)) == pytest.approx(0.01, rel=0.03)
    # The fourth difference of sin(t): 0.05^4 / sqrt(70).
    assert noisiest_std(np.sin(t)) < 1e-6
    assert noisiest_std(noise[:4]) == 0.0
