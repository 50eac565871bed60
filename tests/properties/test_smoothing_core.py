"""What the core smooths, against all states solved for at once."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from reference.dense_spline import DenseSpline
from reference.gauss_markov import GaussMarkov, white_snap

from orbident import _core

pytestmark = pytest.mark.core

SEEDS = st.integers(0, 2**32 - 1)
DENSITIES = st.floats(-6.0, 3.0).map(lambda power: 10.0**power)
"""Densities that give anything from nearly a cubic to a spline through every sample, at
steps of about one."""


def columns(seed, rows, count):
    """Uneven times with a gap, and columns that lack some of their samples."""
    random = np.random.default_rng(seed)
    steps = random.uniform(0.2, 2.0, rows)
    steps[rows // 2] += 5.0
    x = np.cumsum(random.standard_normal((rows, count)), axis=0)
    missing = random.random((rows, count)) < 0.3
    missing[[0, 2, 5, -1]] = False
    return np.cumsum(steps), np.where(missing, np.nan, x)


@given(seed=SEEDS, rows=st.integers(7, 18), density=DENSITIES)
def test_mean_and_deviations_equal_the_dense_smoother(seed, rows, density):
    t, x = columns(seed, rows, 1)
    h, noise_std, offset = 0.7, 0.3, -2.0
    units = np.array([[density], [h], [noise_std], [offset]])
    found = _core.smooth_columns(t, x, *units)
    F, Q = white_snap(np.diff(t) / h, density)
    # Samples in units of the noise: only deviations know of their unit here.
    dense = GaussMarkov(F, Q, np.eye(1, 4), x - offset, 1.0)
    units = (1.0, 1 / h, 1 / h**2)
    for a, unit in enumerate(units):
        expected = dense.mean[:, a] * unit + (offset if a == 0 else 0.0)
        # The dense triangle has a condition of up to 1e7.
        np.testing.assert_allclose(
            found[a][0], expected, atol=1e-8 * np.abs(dense.mean).max()
        )
    for a, unit in enumerate(units[:2]):
        std = noise_std * unit * np.sqrt(dense.covariance[:, a, a])
        np.testing.assert_allclose(found[3 + a][0], std, rtol=1e-7)


@given(seed=SEEDS, rows=st.integers(8, 25), density=DENSITIES)
def test_evidence_equals_the_dense_likelihood(seed, rows, density):
    """But for a constant: of two densities the difference counts."""
    t, x = columns(seed, rows, 1)
    seen = ~np.isnan(x[:, 0])
    t, y = t[seen] - t[0], x[seen, 0]
    densities = np.array([density, 3 * density])
    misfit, log_det = _core.smoothing_evidence(t[None], y[None], densities)
    cost = (misfit + log_det)[0]
    expected = [DenseSpline(t, y, q, 1.0).cost for q in densities]
    # The dense covariance has a condition of up to 1e13, its determinant is a
    # difference of large logarithms.
    assert cost[1] - cost[0] == pytest.approx(expected[1] - expected[0], abs=1e-4)


@settings(max_examples=10)
@given(seed=SEEDS, rows=st.integers(3000, 5000))
def test_blocks_and_threads_do_not_show(seed, rows):
    t, x = columns(seed, rows, 3)
    units = np.array([[1e-3, 1.0, 1e2], np.ones(3), np.ones(3), np.zeros(3)])
    found = _core.smooth_columns(t, x, *units, threads=1)
    for once, again in zip(
        found, _core.smooth_columns(t, x, *units, threads=2), strict=True
    ):
        np.testing.assert_array_equal(once, again)
    alone = _core.smooth_rates(t, x, *units, threads=2)
    for once, again in zip(found[:2], alone, strict=True):
        np.testing.assert_array_equal(once, again)
    # Without its first samples a column has its blocks elsewhere; 500 samples on it
    # has forgotten them.
    moved = _core.smooth_columns(t[100:], x[100:], *units)
    for once, again in zip(found, moved, strict=True):
        scale = np.nanmax(np.abs(once))
        np.testing.assert_allclose(
            again[:, 500:], once[:, 600:], rtol=1e-9, atol=1e-11 * scale
        )


def test_evidence_does_not_depend_on_threads():
    t, x = columns(0, 4096, 1)
    x = np.where(np.isnan(x), 0.0, x)
    both = [
        _core.smoothing_evidence(
            t.reshape(4, -1), x.reshape(4, -1), np.logspace(-9, 3, 8), threads
        )
        for threads in (1, 2)
    ]
    np.testing.assert_array_equal(both[0], both[1])


def test_a_column_without_samples_is_nan():
    t, one = np.arange(5.0), np.ones(1)
    for values in _core.smooth_columns(t, np.full((5, 1), np.nan), one, one, one, one):
        assert np.isnan(values).all()
    for values in _core.smooth_columns(t[:0], np.zeros((0, 1)), one, one, one, one):
        assert values.shape == (1, 0)


@pytest.mark.parametrize(
    ("changed", "error", "message"),
    [
        ({"t": np.arange(4.0)}, ValueError, r"x has the shape \(5, 2\); give \(4, any"),
        ({"x": np.ones(5)}, ValueError, r"x has the shape \(5,\); give \(5, any\)"),
        ({"density": np.ones(3)}, ValueError, r"density has the shape \(3,\)"),
        ({"h": np.ones(2, dtype=np.float32)}, TypeError, "h is not float64"),
    ],
)
def test_wrong_arrays_are_named(changed, error, message):
    arrays = {"t": np.arange(5.0), "x": np.ones((5, 2))}
    arrays |= {name: np.ones(2) for name in ("density", "h", "noise_std", "offset")}
    with pytest.raises(error, match=message):
        _core.smooth_columns(**(arrays | changed))
