"""White noise passes, and what is slow does not, however small."""

import numpy as np

from orbident.estimation.levels import integrated_out, low_frequencies

N = 2000
T = np.arange(N) / 10


def noise(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).standard_normal((N, 3))


def test_white_noise_passes():
    for seed in range(300):
        found = low_frequencies(noise(seed), 1.0)
        assert found is not None
        assert found.ratio < found.limit


def test_numbers_integrated_out_are_the_density_of_what_was_shown():
    """The likelihood of `x` is summed over means of the most likely variance."""
    x, mean = 4.0, np.linspace(-60.0, 60.0, 200_001)
    variance = x**2 - 1
    beforehand = np.exp(-(mean**2) / (2 * variance)) / np.sqrt(2 * np.pi * variance)
    likelihood = np.exp(-((x - mean) ** 2) / 2)
    summed = -2 * np.log(np.sum(likelihood * beforehand) * (mean[1] - mean[0]))
    np.testing.assert_allclose(integrated_out(x**2, 0.0, 1), summed, rtol=1e-6)
    np.testing.assert_allclose(integrated_out(2 * x**2, 0.0, 2), 2 * summed, rtol=1e-6)


def test_a_slow_sine_far_below_the_noise_is_seen():
    """Its power at its own line is `N a^2 / 4`, over 50 lines of unit power each."""
    slow = 0.6 * np.sin(2 * np.pi * 0.05 * T)[:, None] * [1.0, 0.0, 0.0]
    found = low_frequencies(noise(1) + slow, 1.0)
    assert found is not None
    assert found.ratio > found.limit


def test_spikes_are_not_slow():
    spoiled = noise(2)
    spoiled[::500] += 50.0
    found = low_frequencies(spoiled, 1.0)
    assert found is not None
    assert found.ratio < found.limit


def test_few_samples_say_nothing():
    assert low_frequencies(noise(3)[:100], 1.0) is None
    assert low_frequencies(np.zeros((N, 3)), 0.0) is None
