"""What is drawn has the extremes of all samples, in every column of pixels."""

from itertools import pairwise

import numpy as np
import pytest

from orbident.report.charts import extremes, with_gaps


@pytest.mark.parametrize("columns", [1, 7, 100])
@pytest.mark.parametrize("even", [True, False])
def test_extremes_of_every_column(columns: int, even: bool):
    random = np.random.default_rng(columns)
    n = 1000
    steps = np.ones(n) if even else random.exponential(size=n)
    t, x = np.cumsum(steps), random.standard_normal(n).round(1)
    shown = extremes(t, x, columns)
    assert (np.diff(shown) > 0).all()
    assert shown.size <= 2 * columns
    edges = t[0] + (t[-1] - t[0]) * np.arange(columns + 1) / columns
    for low, high in pairwise(edges):
        # Half open but for the last; an edge may round to either side.
        inside = [i for i in range(n) if low + 1e-9 <= t[i] < high - 1e-9]
        drawn = [i for i in shown if low - 1e-9 <= t[i] <= high + 1e-9]
        if inside:
            assert min(x[drawn]) <= min(x[inside])
            assert max(x[drawn]) >= max(x[inside])


def test_few_samples_are_all_drawn():
    t = np.arange(10.0)
    assert extremes(t, t, 5).tolist() == list(range(10))


def test_a_silent_sensor_leaves_a_gap():
    t = np.concatenate([np.arange(100) / 10, 20 + np.arange(100) / 10])
    at, x = with_gaps(t, np.ones(200))
    assert at.size == 201
    assert np.flatnonzero(np.isnan(x)).tolist() == [100]


def test_even_samples_have_no_gap():
    t = np.arange(50) / 10
    assert with_gaps(t, t)[0] is t or with_gaps(t, t)[0].size == 50
