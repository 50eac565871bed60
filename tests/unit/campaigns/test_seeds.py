import numpy as np
import pytest

from orbident.campaigns.seeds import over_seeds
from orbident.errors import InputError


def test_one_run_a_seed_and_their_statistics():
    done = []
    errors = over_seeds(
        lambda seed: np.array([seed, -2.0]), 3, first=4, progress=done.append
    )
    np.testing.assert_array_equal(errors.runs, [[4, -2], [5, -2], [6, -2]])
    np.testing.assert_allclose(errors.rms, [np.sqrt(77 / 3), 2.0])
    np.testing.assert_array_equal(errors.worst, [6.0, 2.0])
    assert done == [0.0, 1 / 3, 2 / 3]


def test_a_run_without_a_value_leaves_no_statistic():
    values = iter([1.0, np.nan])
    errors = over_seeds(lambda _: np.array([next(values)]), 2)
    assert np.isnan(errors.rms).all()


def test_no_seed_is_refused():
    with pytest.raises(InputError, match="seeds: found 0; give one or more"):
        over_seeds(lambda _: np.zeros(1), 0)
