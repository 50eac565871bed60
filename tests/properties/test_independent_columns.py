"""The independent columns of a matrix against its ranks, worked out by brute force."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from orbident.model.dependencies import independent_columns


@st.composite
def matrices(draw) -> np.ndarray:
    """Small whole numbers, so that columns depend on one another and vanish."""
    rows, columns = draw(st.integers(1, 8)), draw(st.integers(1, 7))
    row = st.lists(st.integers(-2, 2), min_size=columns, max_size=columns)
    return np.array(draw(st.lists(row, min_size=rows, max_size=rows)), dtype=float)


def rank(X: np.ndarray) -> int:
    return int(np.linalg.matrix_rank(X)) if X.size else 0


@given(matrices())
def test_kept_are_the_columns_that_raise_the_rank(X):
    brute = [k for k in range(X.shape[1]) if rank(X[:, : k + 1]) > rank(X[:, :k])]
    assert independent_columns(X).columns == brute


@given(matrices())
def test_T_makes_up_all_columns(X):
    kept = independent_columns(X)
    # A few operations on numbers up to 2, with conditions up to 1e2.
    np.testing.assert_allclose(X[:, kept.columns] @ kept.T, X, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(kept.T[:, kept.columns], np.eye(len(kept.columns)))


@given(matrices(), st.lists(st.integers(-12, 12), min_size=7, max_size=7))
def test_units_do_not_matter(X, exponents):
    """Columns in other units: the same are kept, as long as 1e-8 is not exceeded."""
    scale = 2.0 ** np.array(exponents[: X.shape[1]])
    kept, scaled = independent_columns(X), independent_columns(X * scale)
    assert scaled.columns == kept.columns
    T = kept.T * scale / scale[kept.columns][:, None]
    # Powers of two scale without rounding; the entries grow up to 2^24.
    np.testing.assert_allclose(
        scaled.T, T, rtol=1e-10, atol=1e-9 * np.abs(T).max(initial=1)
    )
