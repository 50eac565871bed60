"""Coloured noise against its autocovariance in closed form."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from orbident.robot.sensor_schema import AttitudeSpec, PositionSpec
from orbident.simulation.sensor import markov, random_walk, read_attitude, read_position

DRAWS = 20_000
TIMES = np.array([0.0, 0.01, 0.05, 0.3, 0.31, 2.0, 9.0])
"""s; as uneven as recordings may be."""


def drawn(process, *arguments):
    """Times x draws: each axis is one draw."""
    each = [np.full(DRAWS, value) for value in arguments]
    return process(np.random.default_rng(0), TIMES, *each)


def covariance(x):
    return x @ x.T / DRAWS


def test_markov_has_the_autocovariance_at_any_sample_times():
    s, T = 2.0, 0.7
    expected = s**2 * np.exp(-np.abs(TIMES[:, None] - TIMES) / T)
    # 2e4 draws: 1 % of the variance on the diagonal, 0.7 % off it.
    found = covariance(drawn(markov, s, T))
    np.testing.assert_allclose(found, expected, atol=0.04 * s**2)


def test_random_walk_has_the_variance_of_the_time_that_has_passed():
    q = 0.3
    expected = q**2 * np.minimum(TIMES[:, None], TIMES)
    found = covariance(drawn(random_walk, q))
    np.testing.assert_allclose(found, expected, atol=0.04 * q**2 * TIMES[-1])
    np.testing.assert_array_equal(found[0], 0.0)


def test_a_tracker_adds_all_three_on_each_axis():
    tracker = PositionSpec(
        std=1e-3,
        markov_std=(2e-3, 0.0, 0.0),
        correlation_time=(0.5, 1.0, 1.0),
        random_walk=(0.0, 1e-3, 0.0),
    )
    dt, n = 0.1, 100_000
    error = read_position(tracker, np.zeros((n, 3)), dt, np.random.default_rng(1))
    # Correlated for 10 samples: 2e4 independent ones, 1 %.
    lag = 3
    found = np.mean(error[lag:, 0] * error[:-lag, 0])
    assert found == pytest.approx(4e-6 * np.exp(-lag * dt / 0.5), rel=0.05)
    assert error[:, 0].var() == pytest.approx(5e-6, rel=0.05)
    steps = np.diff(error[:, 1])
    # Increments: of the walk q^2 dt, of white noise twice its variance.
    assert steps.var() == pytest.approx(1e-6 * dt + 2e-6, rel=0.02)
    assert error[:, 2].std() == pytest.approx(1e-3, rel=0.01)


def test_attitude_noise_is_about_the_axes_of_the_base():
    tracker = AttitudeSpec(
        angle=0.0, markov_std=(0.0, 0.0, 1e-3), correlation_time=(1.0, 1.0, 1.0)
    )
    true = np.tile(Rotation.from_rotvec([1.0, 2.0, 0.5]).as_quat(), (5000, 1))
    shown = read_attitude(tracker, true, 0.05, np.random.default_rng(2))
    d = (Rotation.from_quat(true).inv() * Rotation.from_quat(shown)).as_rotvec()
    np.testing.assert_allclose(d[:, :2], 0.0, atol=1e-15)
    # 250 s are 125 independent values: 6 %.
    assert d[:, 2].std() == pytest.approx(1e-3, rel=0.25)


def test_white_noise_is_as_it_was():
    true = np.zeros((50, 3))
    white = read_position(PositionSpec(std=1.0), true, 0.1, np.random.default_rng(3))
    more = PositionSpec(std=1.0, random_walk=(1e-9, 1e-9, 1e-9))
    both = read_position(more, true, 0.1, np.random.default_rng(3))
    np.testing.assert_allclose(both, white, atol=1e-7)
