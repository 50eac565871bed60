import numpy as np
import pytest
from allan import allan_deviation
from scipy.spatial.transform import Rotation

from orbident.robot.sensor_schema import AccelerometerSpec, GyroSpec
from orbident.robot.units import quantity
from orbident.simulation.sensor import (
    read_increments,
    read_inertial,
)

# The paper's gyro (Section 3.5), SI: 0.01 deg/sqrt(h), 0.3 deg/h.
N = np.deg2rad(0.01) / 60
B = np.deg2rad(0.3) / 3600
STILL = np.zeros((200_000, 3))
MOVING = np.random.default_rng(9).standard_normal((50, 3))


def random(seed=0):
    return np.random.default_rng(seed)


def test_exact_without_errors():
    for sensor in (GyroSpec(), AccelerometerSpec()):
        np.testing.assert_array_equal(
            read_inertial(sensor, MOVING, 0.05, random()), MOVING
        )


def test_the_papers_units_are_these():
    assert pytest.approx(N) == quantity("0.01 deg/sqrt(h)", "angle random walk")
    assert pytest.approx(B) == quantity("0.3 deg/h", "angular rate")


def test_allan_deviation_has_the_slope_and_the_floor_of_the_data_sheet():
    gyro = GyroSpec(angle_random_walk=N, bias_instability=B, correlation_time=100.0)
    dt = 0.1
    means = [1, 10, 1890]
    shown = np.hstack([read_inertial(gyro, STILL, dt, random(k)) for k in range(4)])
    found = allan_deviation(shown, dt, means)
    tau = dt * np.array(means)
    # Where tau is small white noise alone; at 1.89 T the peak of the bias, 0.664 B,
    # and what is left of the white noise.
    assert found[0] == pytest.approx(N / np.sqrt(tau[0]), rel=0.01)
    assert found[1] == pytest.approx(N / np.sqrt(tau[1]), rel=0.02)
    # 1200 independent means: 2 %, three times that.
    floor = np.hypot(0.664 * B, N / np.sqrt(tau[2]))
    assert found[2] == pytest.approx(floor, rel=0.07)


def test_white_noise_has_the_std_of_the_sensors_own_interval():
    accelerometer = AccelerometerSpec(velocity_random_walk=3e-4)
    for dt in (0.05, 0.01):
        shown = read_inertial(accelerometer, STILL, dt, random(1))
        # 6e5 samples: 0.1 %.
        assert shown.std() == pytest.approx(3e-4 / np.sqrt(dt), rel=5e-3)


@pytest.mark.parametrize(("turn_on", "std"), [(None, B), (0.0, 0.0), (5 * B, 5 * B)])
def test_the_bias_at_turn_on_is_drawn_once(turn_on, std):
    gyro = GyroSpec(bias_instability=B, turn_on_bias=turn_on, correlation_time=np.inf)
    shown = np.array(
        [read_inertial(gyro, STILL[:3], 0.05, random(k)) for k in range(2000)]
    )
    # Constant over a record; 6000 of them have a std known to 0.9 %.
    assert not np.ptp(shown, axis=1).any()
    assert shown[:, 0].std() == pytest.approx(std, rel=0.04)


def test_constant_bias_and_scale():
    gyro = GyroSpec(constant_bias=(0.1, 0.2, -0.3), scale=(0.01, 0.0, -0.02))
    expected = MOVING * [1.01, 1.0, 0.98] + [0.1, 0.2, -0.3]
    np.testing.assert_allclose(
        read_inertial(gyro, MOVING, 0.05, random()), expected, rtol=1e-14
    )


def test_misalignment_turns_the_sensor_not_the_vector():
    turned = GyroSpec(misalignment=(0.0, 0.0, np.pi / 2))
    # Its x axis is the base's y, its y the base's -x.
    expected = np.column_stack([MOVING[:, 1], -MOVING[:, 0], MOVING[:, 2]])
    np.testing.assert_allclose(
        read_inertial(turned, MOVING, 0.05, random()), expected, atol=1e-15
    )


def test_increments_sum_to_the_change_of_velocity():
    t = np.linspace(0.0, 10.0, 201)
    v = np.column_stack([np.sin(t), t**2, np.cos(3 * t)])
    turn = Rotation.from_rotvec(np.column_stack([0.3 * t, -0.2 * t, np.sin(t)]))
    exact = AccelerometerSpec(increments=True)
    true = np.hstack([turn.as_quat(), v])
    increments = read_increments(exact, true, 0.05, random())
    assert np.isnan(increments[0]).all()
    change = turn[:-1].apply(increments[1:]).sum(axis=0)
    # Rounding of 200 terms.
    np.testing.assert_allclose(change, v[-1] - v[0], atol=1e-12)


def test_increments_have_the_noise_of_a_random_walk_and_the_bias_times_dt():
    dt = 0.02
    accelerometer = AccelerometerSpec(
        velocity_random_walk=3e-4, constant_bias=(1e-3, 0.0, 0.0), increments=True
    )
    at_rest = np.tile([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], (50_000, 1))
    shown = read_increments(accelerometer, at_rest, dt, random(2))[1:]
    # 5e4 samples an axis: 0.3 % of the std.
    np.testing.assert_allclose(shown.std(axis=0), 3e-4 * np.sqrt(dt), rtol=0.015)
    standard_error = 3e-4 * np.sqrt(dt / len(shown))
    np.testing.assert_allclose(
        shown.mean(axis=0), [1e-3 * dt, 0, 0], atol=4 * standard_error
    )
