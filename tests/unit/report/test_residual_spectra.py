"""White noise is white, and what is not is seen."""

import numpy as np

from orbident.estimation.predicted import Signal
from orbident.report.spectra import autocorrelation, spectrum, whiteness

RANDOM = np.random.default_rng(3)
WHITE = RANDOM.standard_normal(20_000)
# Five deviations of 1/sqrt(n).
CHANCE = 5 / np.sqrt(WHITE.size)


def _signal(error: np.ndarray) -> Signal:
    t = np.arange(error.size) / 10
    both = error[:, None], np.zeros((error.size, 1))
    return Signal("gyro", ("x",), ("rad/s",), t, *both, 1.0)


def test_white_noise():
    assert abs(whiteness(_signal(WHITE))) < CHANCE
    assert np.abs(autocorrelation(WHITE)).max() < CHANCE
    # Variance over half the rate, 5 Hz; a band averages at least 19 periodograms.
    found = spectrum(np.arange(WHITE.size) / 10, WHITE)
    assert abs(np.mean(found.density**2) * 5 - 1) < 0.1


def test_a_walk_is_not_white():
    x = np.cumsum(WHITE)
    assert whiteness(_signal(x)) > 0.99
    # One less 1/n for every lag.
    assert autocorrelation(x)[0] > 0.99


def test_a_sine_has_a_line_where_it_belongs():
    t = np.arange(20_000) / 10
    found = spectrum(t, np.sin(2 * np.pi * 0.5 * t))
    # A band is 5 % wide.
    assert abs(found.f[found.density.argmax()] / 0.5 - 1) < 0.06
