"""Rows folded into a triangular factor, against normal equations."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orbident import _core

pytestmark = pytest.mark.core


@given(st.integers(1, 70), st.integers(0, 90), st.integers(0, 2**31))
def test_the_factor_has_the_information_of_all_rows(columns, rows, seed):
    random = np.random.default_rng(seed)
    R = np.triu(random.standard_normal((columns, columns)))
    X = random.standard_normal((rows, columns))
    # Columns that no row touches, and a factor that knows nothing yet of some.
    X[:, random.random(columns) < 0.2] = 0.0
    R[random.random(columns) < 0.2] = 0.0
    found = _core.fold(R, X)
    assert np.array_equal(found, np.triu(found))
    # Rounding of sums of some hundred products.
    np.testing.assert_allclose(found.T @ found, R.T @ R + X.T @ X, atol=1e-11)


def test_heavy_rows_in_the_factor_leave_light_rows_their_digits():
    """An equation that holds to 1e-13 beside one of ordinary noise."""
    R = np.array([[1e13, -1e13, 2e13], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    found = _core.fold(R, np.array([[1.0, 1.0, 4.0]]))
    y = found[1, 2] / found[1, 1]
    x = (found[0, 2] - found[0, 1] * y) / found[0, 0]
    np.testing.assert_allclose([x, y], [3.0, 1.0], rtol=1e-14)


@pytest.mark.parametrize("size", [1e-200, 1e200])
def test_no_square_underflows_or_overflows(size):
    X = size * np.random.default_rng(0).standard_normal((7, 5))
    found = _core.fold(np.zeros((5, 5)), X) / size
    np.testing.assert_allclose(found.T @ found, (X / size).T @ (X / size), atol=1e-13)


def test_a_wrong_shape_names_its_argument():
    with pytest.raises(ValueError, match="rows has the shape"):
        _core.fold(np.eye(3), np.zeros((2, 4)))
