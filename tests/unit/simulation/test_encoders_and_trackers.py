import numpy as np
import pytest
from random_robots import random_quaternion
from scipy.spatial.transform import Rotation

from orbident.robot.sensor_schema import AttitudeSpec, PositionSpec
from orbident.simulation.sensor import read_attitude, read_position, read_scalars

ANGLES = np.linspace(-3.0, 300.0, 100_000)[:, None]
ATTITUDES = np.array([random_quaternion(np.random.default_rng(k)) for k in range(20)])


def random(seed=0):
    return np.random.default_rng(seed)


def test_encoder_noise_is_the_papers():
    error = read_scalars(2.5e-5, 0.0, ANGLES, 0.05, random()) - ANGLES
    # 1e5 samples: 0.22 %.
    assert error.std() == pytest.approx(2.5e-5, rel=0.01)


def test_encoder_counts():
    count = 2 * np.pi / 2**12
    shown = read_scalars(0.0, count, ANGLES, 0.05, random())
    assert np.abs(shown - ANGLES).max() <= count / 2 * (1 + 1e-9)
    # Counted over full turns: 303 rad are 197 532 counts.
    assert np.unique(np.round(shown / count)).size > 50_000


def test_noise_comes_before_counting():
    count = 1e-3
    shown = read_scalars(5e-3, count, ANGLES, 0.05, random())
    np.testing.assert_allclose(shown / count, np.round(shown / count), atol=1e-6)
    # The variances add (Sheppard).
    expected = np.hypot(5e-3, count / np.sqrt(12))
    assert (shown - ANGLES).std() == pytest.approx(expected, rel=0.01)


def test_attitude_errors_are_small_rotations_of_equal_size_about_each_base_axis():
    angle = np.deg2rad(0.02)
    true = np.repeat(ATTITUDES, 5000, axis=0)
    shown = read_attitude(AttitudeSpec(angle=angle), true, 0.05, random(1))
    np.testing.assert_allclose(np.linalg.norm(shown, axis=1), 1.0, rtol=1e-14)
    d = (Rotation.from_quat(true).inv() * Rotation.from_quat(shown)).as_rotvec()
    covariance = d.T @ d / len(d)
    # 1e5 samples: 0.45 % on the diagonal, 0.32 % off it.
    np.testing.assert_allclose(covariance / angle**2, np.eye(3), atol=0.02)
    assert np.abs(d.mean(axis=0)).max() < 5 * angle / np.sqrt(len(d))


def test_large_attitude_errors_have_the_size_that_was_drawn():
    shown = read_attitude(AttitudeSpec(angle=1.0), ATTITUDES, 0.05, random(2))
    drawn = np.random.default_rng(2).standard_normal((len(ATTITUDES), 3))
    expected = Rotation.from_quat(ATTITUDES) * Rotation.from_rotvec(drawn)
    difference = expected.inv() * Rotation.from_quat(shown)
    np.testing.assert_allclose(difference.magnitude(), 0.0, atol=1e-14)


def test_attitude_without_noise_is_exact_and_normalised():
    shown = read_attitude(AttitudeSpec(angle=0.0), 1.001 * ATTITUDES, 0.05, random())
    np.testing.assert_allclose(shown, ATTITUDES, rtol=0, atol=1e-15)


def test_an_attitude_that_is_missing_stays_missing():
    missing = np.full((2, 4), np.nan)
    assert np.isnan(
        read_attitude(AttitudeSpec(angle=0.1), missing, 0.05, random())
    ).all()


def test_position_noise():
    true = np.tile([1.0, -2.0, 300.0], (50_000, 1))
    error = read_position(PositionSpec(std=1e-4), true, 0.05, random()) - true
    # 5e4 samples an axis: 0.3 %.
    np.testing.assert_allclose(error.std(axis=0), 1e-4, rtol=0.015)
