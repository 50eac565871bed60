import tracemalloc

import numpy as np
import pytest

from orbident.errors import InputError
from orbident.preprocessing.rates import fill, spline_rates

# Unequal steps; a not-a-knot spline reproduces a cubic to rounding.
T = np.sort(np.concatenate([np.linspace(0, 2, 9), [0.1, 0.77, 1.3]]))
CUBIC = np.polynomial.Polynomial([0.3, -1.0, 0.5, 0.25])


def with_gaps(x, *gaps):
    x = x.copy()
    x[list(gaps)] = np.nan
    return x


def test_cubic_is_differentiated_exactly():
    np.testing.assert_allclose(
        spline_rates(T, CUBIC(T)), CUBIC.deriv()(T), rtol=0, atol=1e-12
    )


def test_gaps_are_skipped():
    x = with_gaps(CUBIC(T), 2, 3, 7)
    np.testing.assert_allclose(spline_rates(T, x), CUBIC.deriv()(T), atol=1e-12)
    np.testing.assert_allclose(fill(T, x), CUBIC(T), atol=1e-12)


def test_measured_values_stay_to_the_bit():
    x = with_gaps(np.sin(T), 4)
    kept = ~np.isnan(x)
    np.testing.assert_array_equal(fill(T, x)[kept], x[kept])


def test_nothing_is_extrapolated():
    x = with_gaps(CUBIC(T), 0, 1, -1)
    outside = np.zeros(T.size, dtype=bool)
    outside[[0, 1, -1]] = True
    np.testing.assert_array_equal(np.isnan(fill(T, x)), outside)
    np.testing.assert_array_equal(np.isnan(spline_rates(T, x)), outside)


def test_columns_are_independent():
    x = np.stack([CUBIC(T), with_gaps(np.sin(T), 3)], axis=1)
    rates = spline_rates(T, x)
    assert rates.shape == x.shape
    for k in range(2):
        np.testing.assert_array_equal(rates[:, k], spline_rates(T, x[:, k]))
        np.testing.assert_array_equal(fill(T, x)[:, k], fill(T, x[:, k]))


def test_input_is_not_changed():
    x = with_gaps(np.sin(T), 4)
    before = x.copy()
    x.flags.writeable = False
    fill(T, x)
    spline_rates(T, x)
    np.testing.assert_array_equal(x, before)


def test_error_falls_with_the_cube_of_the_step():
    def error(n):
        t = np.linspace(0, 1, n)
        return np.abs(spline_rates(t, np.sin(5 * t)) - 5 * np.cos(5 * t)).max()

    # 2^3 for a derivative of a cubic spline, less a little at the ends.
    assert error(101) / error(201) > 7


@pytest.mark.parametrize("work", [spline_rates, fill])
def test_refusals(work):
    few = np.full(T.size, np.nan)
    few[:3] = 1.0
    with pytest.raises(InputError, match=r"q has 3 samples; .* at least 4"):
        work(T, few, "q")
    with pytest.raises(InputError, match=r"x\[:, 1\] has 3 samples"):
        work(T, np.stack([T, few], axis=1))
    with pytest.raises(InputError, match="give finite samples"):
        work(T, np.where(T > 1, np.inf, T))
    with pytest.raises(InputError, match="strictly increasing"):
        work(np.zeros(5), np.arange(5.0))


def test_memory_is_bounded_by_one_column():
    t = np.arange(100_000) * 0.05
    x = np.repeat(np.sin(t)[:, None], 14, axis=1)
    tracemalloc.start()
    spline_rates(t, x)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    # The result, and what SciPy's spline of one column takes (about 15 columns).
    assert peak < x.nbytes + 20 * t.nbytes
