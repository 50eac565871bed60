import numpy as np
import pytest
from scipy.signal import periodogram

from orbident.errors import InputError
from orbident.preprocessing.low_pass import HIGHEST, choose_cut_off, low_pass
from orbident.studies.paper_tables import spatial_robot, spatial_trajectory

RATE, STD = 20.0, 1e-3
T = np.arange(1601) / RATE


def noise(seed, n=T.size):
    return STD * np.random.default_rng(seed).standard_normal(n)


def joint(k, ends=slice(None)):
    q, _, _ = spatial_trajectory(spatial_robot()).at(T)
    return q[ends, k]


@pytest.mark.parametrize("std", [2.5e-5, 1e-3])
@pytest.mark.parametrize("ends", [slice(None), slice(317, 1343)])
def test_hardly_any_other_cut_off_would_be_better(std, ends):
    t = T[ends]
    q = np.stack([joint(k, ends) for k in range(3)], axis=1)
    y = q + std / STD * np.stack([noise(k, t.size) for k in range(3)], axis=1)

    def error(cut_off):
        return np.sqrt(np.mean((low_pass(t, y, cut_off) - q) ** 2, axis=0))

    least = np.min([error(f) for f in np.geomspace(0.1, 1.0, 7)], axis=0)
    for k in range(3):
        chosen = choose_cut_off(t, y[:, k])
        # Measured: 0.99 to 1.05.
        assert error(chosen.frequency)[k] < 1.2 * least[k]
        # 1600 and 1026 samples know their std to 1.8 and 2.2 %; four times that.
        np.testing.assert_allclose(chosen.noise_std, std, rtol=0.09)
        # Noise that passes has some 30 independent values: 13 %; twice that.
        assert chosen.error.min() == pytest.approx(least[k], rel=0.3)


def test_every_line_has_the_amplitude_of_its_sine():
    # A whole number of periods: no leakage.
    t = np.arange(2000) / RATE
    chosen = choose_cut_off(t, 0.3 * np.sin(2 * np.pi * 2.0 * t) + noise(1, t.size))
    # A window spreads a sine over its lines: their squares add up to its own.
    near = np.abs(chosen.f - 2.0) < 0.03
    assert np.sqrt((chosen.amplitude[near] ** 2).sum()) == pytest.approx(0.3, rel=0.01)
    f, density = periodogram(noise(1, t.size), RATE)
    np.testing.assert_allclose(chosen.f, f[1:], rtol=1e-12)
    expected = np.sqrt(2 * density[1:].mean() * f[1])
    # 250 lines have a median known to 6 %, half that as amplitude; twice that.
    assert chosen.noise_amplitude == pytest.approx(expected, rel=0.07)


def test_the_residual_of_noise_alone_is_the_straight_line():
    chosen = choose_cut_off(T, noise(2))
    # Where there is no signal both curves are one: 800 lines, 2.5 % each way.
    np.testing.assert_allclose(
        chosen.residual[:80], chosen.noise_residual[:80], rtol=0.12
    )
    square = (chosen.noise_residual / chosen.noise_std) ** 2
    low = chosen.cut_offs < 2.0
    # The filter's skirts take a little more than the ideal 1 - f / f_max leaves.
    np.testing.assert_allclose(
        square[low], 1 - chosen.cut_offs[low] / (RATE / 2), atol=0.06
    )


def test_noise_without_a_signal_leaves_almost_nothing():
    for seed in range(4):
        assert choose_cut_off(T, noise(seed)).frequency < 0.05 * RATE / 2


def test_without_noise_nothing_is_filtered():
    for x in (joint(1), joint(1, slice(317, 1343)), np.full(500, 0.7), np.zeros(500)):
        chosen = choose_cut_off(T[: x.size], x)
        assert chosen.frequency == pytest.approx(HIGHEST * RATE / 2)
        assert chosen.noise_std == 0.0
        y = low_pass(T[: x.size], x[:, None], chosen.frequency)[:, 0]
        # No cubic continues the motion exactly beyond its ends.
        np.testing.assert_allclose(y, x, rtol=0, atol=1e-8)


def test_few_samples():
    for n in (4, 5, 10):
        chosen = choose_cut_off(T[:n], np.sin(T[:n]))
        assert 0 < chosen.frequency <= HIGHEST * RATE / 2


def test_refusals():
    x = joint(0)
    with pytest.raises(InputError, match="q: 1 values are missing"):
        choose_cut_off(T, np.where(T == 5.0, np.nan, x), name="q")
    with pytest.raises(InputError, match=r"q: time .* resample at even times"):
        choose_cut_off(T**1.1, x, name="q")
    with pytest.raises(InputError, match="q has 3 samples"):
        choose_cut_off(T[:3], x[:3], name="q")
