"""Numbers that are no state of a filter, or of a detector, are refused."""

import numpy as np
import pytest
from core_calls import Call, core_calls
from random_robots import random_robot, random_wheels

from orbident import _core

pytestmark = pytest.mark.core

LINEAR = 40
"""Where the count of hand_over.hpp is: behind t, w, impulses and R_WB, each padded to
eights."""


@pytest.fixture(scope="module")
def calls() -> dict[str, Call]:
    robot = random_robot(1, (0, 1), (1,), random_wheels(1, ["held"]))
    return {call.name: call for call in core_calls(robot)}


def test_every_number_of_a_state_is_looked_at(calls: dict[str, Call]):
    core, numbers = calls["Filter.restored"].arguments
    assert np.array_equal(core.restored(numbers).numbers, numbers)
    for k in (0, *range(8, 11), 16, *range(24, numbers.size)):
        for bad in (np.inf, -np.inf) if k < 24 else (np.nan, np.inf):
            spoilt = numbers.copy()
            spoilt[k] = bad
            with pytest.raises(ValueError, match="no state of a filter"):
                core.restored(spoilt)
    for count in (-1.0, 0.5, 33.0, 1e300):
        spoilt = numbers.copy()
        spoilt[LINEAR] = count
        with pytest.raises(ValueError, match="no state of a filter"):
            core.restored(spoilt)
    with pytest.raises(ValueError, match="no state of a filter"):
        core.restored(np.zeros(numbers.size))


@pytest.mark.parametrize(
    ("times", "sound"),
    [
        ((np.nan, np.nan, np.nan, np.nan), True),
        ((np.nan, 1.0, 2.0, np.nan), True),
        ((0.0, 1.0, 2.0, 3.0), False),
        ((np.nan, 2.0, 1.0, np.nan), False),
        ((1.0, np.nan, 2.0, np.nan), False),
        ((np.nan, 1.0, np.inf, np.nan), False),
    ],
)
def test_times_of_a_detector_grow(times: tuple[float, ...], sound: bool):
    """Three samples, and one to come; of two sums each."""
    numbers = np.concatenate([np.zeros(8), times])
    if sound:
        kept = _core.Watch.restored(2, 3, numbers).numbers
        np.testing.assert_array_equal(kept, numbers)
        return
    with pytest.raises(ValueError, match="no state of a detector"):
        _core.Watch.restored(2, 3, numbers)


def test_a_sample_that_does_not_count_is_not_watched(calls: dict[str, Call]):
    """Nor is it a time at which the robot may have changed."""
    core, state, watch, threshold, t, samples = calls["Filter.run"].arguments
    once = core.run(state, watch, threshold, t[1:2], samples[1:2].copy())
    later, twice = np.array([1.0, 9.0]), np.repeat(samples[1:2], 2, axis=0)
    after = core.run(state, watch, threshold, later, twice)
    assert np.array_equal(after[1].numbers, once[1].numbers, equal_nan=True)
    assert after[-1][1, 2] == 0.0
    assert after[-1][1, 3] > 0
