"""White noise is white, and what is not is seen."""

import numpy as np
import pytest
from scipy.signal import welch

from orbident.estimation.estimate import whiteness
from orbident.report.fit import LINES, autocorrelation, power_density, spectrum

RANDOM = np.random.default_rng(3)
WHITE = RANDOM.standard_normal(20_000)
# Five deviations of 1/sqrt(n).
CHANCE = 5 / np.sqrt(WHITE.size)


def test_white_noise():
    assert abs(whiteness(WHITE[:, None])) < CHANCE
    assert np.abs(autocorrelation(WHITE)).max() < CHANCE
    # Variance over half the rate, 5 Hz; a band averages at least 19 periodograms.
    _, density = spectrum(np.arange(WHITE.size) / 10, WHITE)
    assert abs(np.mean(density**2) * 5 - 1) < 0.1


def test_a_walk_is_not_white():
    x = np.cumsum(WHITE)
    assert whiteness(x[:, None]) > 0.99
    # One less 1/n for every lag.
    assert autocorrelation(x)[0] > 0.99


def test_a_sine_has_a_line_where_it_belongs():
    t = np.arange(20_000) / 10
    f, density = spectrum(t, np.sin(2 * np.pi * 0.5 * t))
    # A band is 5 % wide.
    assert abs(f[density.argmax()] / 0.5 - 1) < 0.06


@pytest.mark.parametrize("samples", [2, 7, 1601, 2 * LINES, 5 * LINES + 3])
def test_power_is_that_of_welch(samples: int):
    x = 0.3 + WHITE[:samples]
    f, power = power_density(x, 10.0)
    lines, expected = welch(x, 10.0, nperseg=min(samples, 2 * LINES))
    np.testing.assert_allclose(f, lines, rtol=1e-12)
    np.testing.assert_allclose(power, expected, rtol=1e-10, atol=1e-25)
