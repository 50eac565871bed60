import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt

from orbident.errors import InputError
from orbident.preprocessing.low_pass import low_pass, require_even
from orbident.studies.paper_tables import spatial_robot, spatial_trajectory

RATE = 100.0
T = np.arange(2000) / RATE


def test_gain_is_that_of_two_butterworth_filters_and_the_phase_zero():
    for f in (0.5, 2.0, 3.0, 5.0):
        # A whole number of periods from the middle of the record.
        x = np.cos(2 * np.pi * f * (T - 10.0))[:, None]
        middle = slice(800, 1200)
        found = low_pass(T, x, 2.0)[middle, 0]
        # The bilinear transform bends frequencies.
        bent, cut = np.tan(np.pi * np.array([f, 2.0]) / RATE)
        gain = 1 / (1 + (bent / cut) ** 8)
        np.testing.assert_allclose(found, gain * x[middle, 0], atol=2e-3)
        if f == 2.0:
            assert gain == pytest.approx(0.5)


def test_cubics_pass():
    x = np.polynomial.Polynomial([0.3, -1.0, 0.5, 0.02])(T - 7)[:, None]
    for cut_off in (0.3, 1.0, 10.0):
        # The continuation ends after five periods of the cut-off, and the slowest of
        # the filter's modes decays by exp(-2 pi sin(pi / 8)) in each: 6e-6 is left of
        # the start, which is larger there than the record.
        error = np.abs(low_pass(T, x, cut_off) - x)
        assert error.max() < 1e-5 * np.ptp(x)


def test_columns_are_independent():
    x = np.random.default_rng(1).standard_normal((500, 3)).cumsum(axis=0)
    together = low_pass(T[:500], x, 1.0)
    for k in range(3):
        alone = low_pass(T[:500], x[:, [k]], 1.0)
        np.testing.assert_allclose(together[:, [k]], alone, rtol=1e-9)


def table_2(ends):
    t = np.arange(1601) * 0.05
    q, _, _ = spatial_trajectory(spatial_robot()).at(t)
    return t[ends], q[ends]


@pytest.mark.parametrize(
    ("ends", "most"),
    # At rest and in motion; measured over 20 seeds: 0.60 and 0.54.
    [(slice(None), 0.75), (slice(317, 1343), 0.7)],
)
def test_the_first_sample_is_not_frozen(ends, most):
    t, q = table_2(ends)
    seeds, std = 8, 2.5e-5
    draws = std * np.random.default_rng(2).standard_normal((seeds, *q.shape))
    y = np.concatenate(q + draws, axis=1)
    true = np.tile(q, (1, seeds))
    error = low_pass(t, y, 0.5) - true
    sections = butter(4, 0.5, fs=20, output="sos")
    frozen = sosfiltfilt(sections, y, axis=0, padlen=200) - true
    rms = np.sqrt((error[[0, -1]] ** 2).mean()) / std
    rms_frozen = np.sqrt((frozen[[0, -1]] ** 2).mean()) / std
    # 48 ends know their RMS to 10 %; two and a half times that.
    assert rms < most
    assert rms_frozen > 0.9
    # Inside, both are the same filter.
    np.testing.assert_allclose(error[300:-300], frozen[300:-300], atol=1e-3 * std)


def test_times_printed_with_few_digits_are_even():
    t = np.round(np.arange(1000) / 30, 3)
    assert require_even(t, t, "x") == pytest.approx(30, rel=1e-4)


@pytest.mark.parametrize(
    ("t", "x", "cut_off", "message"),
    [
        (T[:3], T[:3], 1.0, "q has 3 samples; filtering needs at least 4"),
        (T[[0, 1, 2, 3, 5]], T[:5], 1.0, "s from even steps of .*; resample at even"),
        (T[:5], [0, 1, np.nan, 3, 4], 1.0, "q: 1 values are missing .* fill the gaps"),
        (T[:5], T[:5], 50.0, "cut-off 50 Hz; give one between 0 and 50 Hz, half the"),
        (T[:5], T[:5], 0.0, "cut-off 0 Hz; give one between"),
        (T[:5], T[:5], np.nan, "cut-off nan Hz; give one between"),
    ],
)
def test_refusals(t, x, cut_off, message):
    with pytest.raises(InputError, match=message):
        low_pass(t, np.array(x, dtype=float)[:, None], cut_off, name="q")
