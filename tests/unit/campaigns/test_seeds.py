from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from orbident.campaigns.executors import Executors, InThisProcess
from orbident.campaigns.seeds import ONE_RUN, Errors, SeedRuns, Series
from orbident.errors import InputError


def once(run: Callable[[int], np.ndarray], seeds: range, **options) -> Errors:
    (errors,) = SeedRuns(**options).over(Series(run, seeds))
    return errors


def test_one_run_a_seed_and_their_statistics():
    done = []
    errors = once(
        lambda seed: np.array([seed, -2.0]), range(4, 7), progress=done.append
    )
    np.testing.assert_array_equal(errors.runs, [[4, -2], [5, -2], [6, -2]])
    np.testing.assert_allclose(errors.rms, [np.sqrt(77 / 3), 2.0])
    np.testing.assert_array_equal(errors.worst, [6.0, 2.0])
    assert done == [1 / 3, 2 / 3, 1.0]


@pytest.mark.parametrize("executors", [InThisProcess, lambda: ThreadPoolExecutor(3)])
def test_several_series_wherever_they_run(executors: Executors):
    made: list[int] = []

    def run(seed: int) -> np.ndarray:
        made.append(seed)
        return np.array([float(seed)])

    known = (np.array([-1.0]), np.array([-2.0]))
    series = [Series(run, range(100), made=known), Series(lambda k: -run(k), range(3))]
    one, other = SeedRuns(executors=executors).over(*series)
    np.testing.assert_array_equal(one.runs[:, 0], [-1.0, -2.0, *range(2, 100)])
    np.testing.assert_array_equal(other.runs[:, 0], [0, -1, -2])
    assert sorted(made) == sorted([*range(3), *range(2, 100)])


def test_what_is_known_is_not_run():
    assert once(lambda _: np.ones(1), range(1)).runs.shape == (1, 1)
    (errors,) = ONE_RUN.over(Series(_fails, range(1), made=(np.zeros(2),)))
    np.testing.assert_array_equal(errors.runs, [[0, 0]])


def test_a_run_that_raises_ends_all():
    with pytest.raises(ZeroDivisionError):
        once(_fails, range(3))


def _fails(seed: int) -> np.ndarray:
    return np.ones(1) * (1 // (seed * 0))


def test_a_run_without_a_value_leaves_no_statistic():
    values = iter([1.0, np.nan])
    errors = once(lambda _: np.array([next(values)]), range(2))
    assert np.isnan(errors.rms).all()


def test_no_seed_is_refused():
    with pytest.raises(InputError, match="seeds: found 0; give one or more"):
        once(lambda _: np.zeros(1), range(0))
