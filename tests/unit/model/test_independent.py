import numpy as np
import pytest

from orbident.model.dependencies import independent_columns


def test_the_leftmost_columns_are_kept():
    X = np.array([[1.0, 2.0, 0.0, 1.0], [0.0, 0.0, 0.0, 1.0], [1.0, 2.0, 0.0, 3.0]])
    kept = independent_columns(X)
    assert kept.columns == [0, 3]
    # Exact but for the normalisation of the columns.
    np.testing.assert_allclose(kept.T, [[1, 2, 0, 0], [0, 0, 0, 1]], atol=1e-15)


@pytest.mark.parametrize("shape", [(3, 0), (0, 3), (3, 2)])
def test_nothing_is_independent_in_nothing(shape):
    kept = independent_columns(np.zeros(shape))
    assert kept.columns == []
    assert kept.T.shape == (0, shape[1])


def test_columns_of_very_different_size():
    """Kilograms beside gram centimetres squared: 1e-7 of the largest still counts."""
    random = np.random.default_rng(0)
    X = random.standard_normal((50, 4)) * [1.0, 1e-7, 1e-3, 1.0]
    assert independent_columns(X).columns == [0, 1, 2, 3]


def test_rounding_is_not_a_column():
    random = np.random.default_rng(0)
    X = random.standard_normal((50, 3))
    noisy = X @ random.standard_normal((3, 2))
    noisy += 1e-13 * random.standard_normal(noisy.shape)
    kept = independent_columns(np.concatenate([X, noisy], axis=1))
    assert kept.columns == [0, 1, 2]


def test_many_nearly_parallel_columns():
    """A distance of 1e-5 from the others still counts; their sum does not."""
    random = np.random.default_rng(0)
    common = random.standard_normal((80, 1))
    X = common + 1e-5 * random.standard_normal((80, 20))
    kept = independent_columns(np.concatenate([X, X @ np.ones((20, 1))], axis=1))
    assert kept.columns == list(range(20))
    # Conditions of 1e5 cost five of sixteen digits, in units of the columns' size.
    np.testing.assert_allclose(X @ kept.T[:, 20], X.sum(axis=1), rtol=1e-10)
