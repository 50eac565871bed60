import numpy as np
import pytest
from allan import allan_deviation

from orbident.robot.sensor_schema import FLICKER_FLOOR, MARKOV_PEAK, GyroSpec
from orbident.simulation.sensor import markov, read_scalars

N = 3e-6
B = 1.5e-6
STD = GyroSpec(bias_instability=B).drift_std
GYRO = GyroSpec(angle_random_walk=N)
SHAPE = (100_000, 8)


def random(seed=0):
    return np.random.default_rng(seed)


def bias_drift(random, shape, std, correlation_time, dt):
    """How a bias drifts from its value at turn-on, on so many axes."""
    n, axes = shape
    each = (np.full(axes, value) for value in (std, correlation_time))
    return markov(random, dt * np.arange(n), *each, from_zero=True)


def quantised(x, step):
    """What an encoder without noise shows."""
    return read_scalars(0.0, step, x, 1.0, random())


@pytest.mark.parametrize("rate", [20.0, 100.0, 2000.0])
def test_white_noise_of_rate_samples_grows_with_the_rate(rate):
    noise = random().normal(0.0, GYRO.white_std(1 / rate), SHAPE)
    # 8e5 samples: their std is known to 0.08 %; five times that.
    assert noise.std() == pytest.approx(N * np.sqrt(rate), rel=4e-3)
    assert abs(noise.mean()) < 5 * N * np.sqrt(rate) / np.sqrt(noise.size)


def test_white_noise_integrates_to_a_random_walk():
    dt, seconds = 0.05, 50.0
    noise = random().normal(0.0, GYRO.white_std(dt), (1000, 4000))
    walk = dt * noise.sum(axis=0)
    # 4000 walks: 1.1 % of their std.
    assert walk.std() == pytest.approx(N * np.sqrt(seconds), rel=0.05)


def test_allan_deviation_of_white_noise_is_the_coefficient_over_root_tau():
    dt, means = 0.01, [1, 4, 16, 64, 256]
    noise = random(1).normal(0.0, GYRO.white_std(dt), SHAPE)
    expected = N / np.sqrt(dt * np.array(means))
    # The longest mean has 390 independent ones an axis, 3100 in all: 1.3 %, three
    # times that; the shorter ones are better known.
    np.testing.assert_allclose(allan_deviation(noise, dt, means), expected, rtol=0.04)


def test_spectrum_of_white_noise_is_flat_at_the_coefficient_squared():
    dt = 0.01
    noise = random(2).normal(0.0, GYRO.white_std(dt), (2**16, 8))
    spectrum = dt / len(noise) * np.abs(np.fft.rfft(noise, axis=0)) ** 2
    # By octave from 0.1 Hz: 500 or more exponential variates each, 4.5 % at most.
    f = np.fft.rfftfreq(len(noise), dt)
    for low in 0.1 * 2.0 ** np.arange(9):
        band = spectrum[(f >= low) & (f < 2 * low)]
        assert band.mean() == pytest.approx(N**2, rel=0.15)


def markov_allan_deviation(x):
    """Allan deviation of a unit first-order Gauss-Markov process, over tau / T (IEEE
    952, C.1.5)."""
    return np.sqrt(2 / x * (1 - (3 - 4 * np.exp(-x) + np.exp(-2 * x)) / (2 * x)))


def test_peak_constants_are_those_of_the_closed_form():
    x = np.linspace(1.5, 2.5, 100_001)
    deviation = markov_allan_deviation(x)
    # It has six digits.
    assert deviation.max() == pytest.approx(MARKOV_PEAK, abs=1e-6)
    assert pytest.approx(0.664, abs=5e-4) == FLICKER_FLOOR


def test_allan_deviation_of_the_drift_peaks_at_the_floor_of_flicker():
    dt, T = 1.0, 20.0
    drift = bias_drift(random(3), (200_000, 8), STD, T, dt)
    means = [10, 20, 38, 76, 200]
    found = allan_deviation(drift, dt, means)
    x = dt * np.array(means) / T
    expected = STD * markov_allan_deviation(x)
    # 1000 independent means of the longest kind an axis: 0.8 %, four times that; the
    # closed form is of the continuous process, half a percent off at ten samples.
    np.testing.assert_allclose(found, expected, rtol=0.035)
    assert found[2] == pytest.approx(FLICKER_FLOOR * B, rel=0.035)
    assert np.argmax(found) == 2


def test_flicker_floor_is_that_of_flicker_noise():
    # Synthesised in frequency, S(f) = B^2 / (2 pi f), independently of our noise.
    n, dt = 2**18, 1.0
    f = np.fft.rfftfreq(n, dt)
    amplitude = np.zeros_like(f)
    amplitude[1:] = B * np.sqrt(n / dt / (2 * np.pi * f[1:]) / 2)
    draws = random(4).standard_normal((2, f.size, 8))
    noise = np.fft.irfft(amplitude[:, None] * (draws[0] + 1j * draws[1]), n, axis=0)
    found = allan_deviation(noise, dt, [30, 100, 300])
    # Means of 30 and more see nothing of the upper end; 4 % is three sigma.
    np.testing.assert_allclose(found, FLICKER_FLOOR * B, rtol=0.04)


def test_drift_starts_at_zero_and_settles_at_its_stationary_std():
    drift = bias_drift(random(5), (200, 20_000), STD, 10.0, 1.0)
    assert not drift[0].any()
    for k in (1, 5, 10, 30, 199):
        expected = STD * np.sqrt(1 - np.exp(-2 * k / 10.0))
        # 20 000 processes: 0.5 %.
        assert drift[k].std() == pytest.approx(expected, rel=0.02)


def test_drift_does_not_depend_on_how_often_it_is_sampled():
    rare = bias_drift(random(6), (11, 20_000), B, 30.0, 1.0)
    often = bias_drift(random(7), (101, 20_000), B, 30.0, 0.1)[::10]
    np.testing.assert_allclose(often[1:].std(axis=1), rare[1:].std(axis=1), rtol=0.03)


def test_a_bias_of_infinite_correlation_time_stays():
    assert not bias_drift(random(), (100, 3), B, np.inf, 0.05).any()


@pytest.mark.parametrize("axes", [1, 3, 7])
def test_axes_are_independent(axes):
    noise = random(8).normal(0.0, 2.0, (50_000, axes))
    covariance = noise.T @ noise / len(noise)
    # Off the diagonal std 4 / sqrt(50 000) = 0.018, on it sqrt(2) times that.
    np.testing.assert_allclose(covariance, 4 * np.eye(axes), atol=0.11)


def test_quantisation_error_is_at_most_half_a_step_and_uniform():
    x = random(9).uniform(-50.0, 50.0, (100_000, 1))
    step = 2 * np.pi / 4096
    shown = quantised(x, step)
    counts = shown / step
    np.testing.assert_allclose(counts, np.round(counts), atol=1e-9)
    error = shown - x
    assert np.abs(error).max() <= step / 2 * (1 + 1e-9)
    # Uniform: step / sqrt(12), known from 1e5 samples to 0.2 %.
    assert error.std() == pytest.approx(step / np.sqrt(12), rel=0.01)
    np.testing.assert_array_equal(quantised(x, 0.0), x)


def test_quantisation_leaves_missing_samples_missing():
    np.testing.assert_array_equal(
        quantised(np.array([[np.nan, 0.6]]), 0.5), [[np.nan, 0.5]]
    )
