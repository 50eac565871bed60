"""Batches change nothing but the size that is compiled."""

import jax
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from orbident.dynamics.batches import in_batches


@settings(max_examples=25)
@given(rows=st.integers(1, 20), size=st.integers(1, 8))
def test_equal_to_direct_evaluation(rows, size):
    random = np.random.default_rng(rows)
    x, y = random.standard_normal((rows, 3)), random.standard_normal(rows)
    calls = []

    def function(x, tree):
        calls.append(x.shape)
        return {"sum": x.sum(axis=1) + tree["y"], "rows": (2 * x, tree["y"])}

    found = in_batches(function, x, {"y": y}, size=size)
    expected = function(x, {"y": y})
    jax.tree.map(np.testing.assert_array_equal, found, expected)
    # Every call but the direct one has the same size.
    assert set(calls[:-1]) == {(size, 3)}
