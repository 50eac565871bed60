"""Innovations against the covariance that they are to whiten, written out."""

import numpy as np
import pytest

from orbident import _core

pytestmark = pytest.mark.core

TIMES = np.array([0.0, 0.02, 0.03, 0.1, 0.5, 0.51, 3.0])


def covariance(t, variance, s, T, q, p):
    between = np.abs(t[:, None] - t)
    walk = q**2 * (np.minimum(t[:, None], t) - t[0])
    first, last = np.minimum(t[:, None], t) - t[0], np.maximum(t[:, None], t) - t[0]
    rate_walk = p**2 * first**2 * (3 * last - first) / 6
    return np.diag(variance) + s**2 * np.exp(-between / T) + walk + rate_walk


@pytest.mark.parametrize(
    ("s", "T", "q", "p"),
    [
        (0.0, 1.0, 0.0, 0.0),
        (2.0, 0.1, 0.0, 0.0),
        (0.0, 1.0, 0.7, 0.0),
        (2.0, 0.1, 0.7, 0.0),
        (0.0, 1.0, 0.0, 0.4),
        (2.0, 0.1, 0.7, 0.4),
    ],
)
def test_innovations_are_those_of_the_triangular_factor(s, T, q, p):
    random = np.random.default_rng(0)
    rows = random.standard_normal((TIMES.size, 3))
    variance = random.uniform(0.1, 1.0, TIMES.size)
    found, S = _core.innovations(TIMES, rows, variance, np.array([s, T, q, p]))
    # C = L L^T: the rows over their deviations are L^-1 rows, row by row.
    L = np.linalg.cholesky(covariance(TIMES, variance, s, T, q, p))
    np.testing.assert_allclose(np.sqrt(S), np.diag(L), rtol=1e-12)
    expected = np.linalg.solve(L, rows)
    np.testing.assert_allclose(found / np.sqrt(S)[:, None], expected, rtol=1e-9)
