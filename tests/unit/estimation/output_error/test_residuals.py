"""What residuals say of the noise, on noise whose size is known."""

import numpy as np
import pytest
from scipy.signal import lfilter

from orbident.estimation.output_error.noise_scaling import (
    HUBER,
    LEAST,
    Whitened,
    change,
    reweighted,
    robust,
    whitened,
)

SAMPLES = 20000


def noise(seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).standard_normal((SAMPLES, 3))


def test_scale_of_white_noise():
    # 60000 numbers: the std of their std is 1 / sqrt(2 n) = 0.3 %.
    assert Whitened(2.5 * noise(), 0.0).scale == pytest.approx(2.5, rel=0.01)


def test_scale_counts_the_unknowns():
    """Noise of 10 samples, 6 of which were used up."""
    values = np.array([[1.0, -1.0]] * 5)
    assert Whitened(values, 6.0).scale == pytest.approx(np.sqrt(10 / 4))


def test_scale_leaves_outliers_out():
    values = noise()
    values[::20] = 1000.0
    # The 5 % of outliers widen the median's bound a little.
    assert Whitened(values, 0.0).scale == pytest.approx(1.0, rel=0.01)


def test_scale_is_never_zero():
    assert Whitened(np.zeros((10, 3)), 0.0).scale == LEAST
    assert Whitened(np.zeros((0, 3)), 0.0).scale == 1.0


def test_whiteness_of_white_and_of_coloured_noise():
    # Std of the correlation of 20000 x 3 pairs: 0.004.
    assert abs(Whitened(noise(), 0.0).whiteness) < 0.02
    for a in (0.5, -0.3):
        coloured = np.asarray(lfilter([1.0], [1.0, -a], noise(), axis=0))
        assert Whitened(coloured, 0.0).whiteness == pytest.approx(a, abs=0.02)
    assert Whitened(np.zeros((10, 3)), 0.0).whiteness == 0.0


def test_rows_without_a_sample_and_axes_that_do_not_count_are_left_out():
    weights = np.ones((8, 3))
    weights[[1, 7]] = 0.0
    weights[:, 2] = 0.0
    found = whitened(weights, np.arange(24.0).reshape(8, 3), 5.0)
    expected = [[0, 1], [6, 7], [9, 10], [12, 13], [15, 16], [18, 19]]
    np.testing.assert_array_equal(found.values, expected)
    assert found.unknowns == 5.0


def test_hubers_weights():
    """The sum of squares grows linearly beyond the threshold: `HUBER |r|`."""
    old = np.ones((3, 1))
    residuals = np.array([[0.5], [-HUBER], [-100.0]])
    again = reweighted(residuals, old, robust(old, residuals)).ravel()
    np.testing.assert_allclose(again**2, [0.25, HUBER**2, HUBER * 100.0])


def test_weights_of_less_noise():
    random = np.random.default_rng(0)
    old = np.where(random.random((10, 3)) < 0.3, 0.0, 2.0)
    residuals = old * random.standard_normal((10, 3))
    np.testing.assert_allclose(reweighted(residuals, old, old / 4), residuals / 4)
    assert change(old, old) == 0.0
    assert change(old, old / 4) == pytest.approx(0.75)
    assert change(np.zeros((1, 1)), np.zeros((1, 1))) == 0.0
