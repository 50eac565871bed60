"""Times of any clock, of several at once, and of none."""

from collections import Counter
from collections.abc import Iterable

import numpy as np
import pytest

from orbident.live.stream_clocks import CLOCKS, LATE, WARM_UP, StreamClocks

DT = 0.05
NOWHERE = slice(0, 0)
"""Where the attitude is of samples that have none."""
TIMES = DT * np.arange(200)


def believed(times: Iterable[float]) -> tuple[list[float], Counter[str], int]:
    """What is believed, what became of the others, and how often a clock took over."""
    clocks, counts, crossed, kept = StreamClocks(NOWHERE), Counter(), 0, []
    given = list(times)
    for t in given:
        heard = clocks.hear(np.array([t, t]), counts)
        crossed += heard.crossed is not None
        kept += [float(row[1]) for row in heard.rows]
    assert len(kept) + sum(counts.values()) + clocks.waiting() == len(given)
    return kept, counts, crossed


def alternating(*senders: np.ndarray) -> np.ndarray:
    return np.column_stack(senders).ravel()


def test_times_that_follow_each_other():
    assert believed(TIMES) == (TIMES.tolist(), Counter(), 1)


@pytest.mark.parametrize("apart", [100.0, 3.0, -30.0, 1.7e9, -1e300])
def test_of_two_senders_one_is_believed(apart: float):
    kept, counts, _ = believed(alternating(TIMES, TIMES + apart))
    assert kept == TIMES.tolist()
    assert sum(counts.values()) == len(TIMES) - 1  # the last one waits


def test_senders_of_many_samples_at_once_do_not_take_turns():
    groups = TIMES.reshape(-1, 10)
    kept, counts, _ = believed(np.hstack([groups, groups + 100.0]).ravel())
    assert kept == TIMES.tolist()
    assert counts["foreign"] == len(TIMES) - 10


@pytest.mark.parametrize("leap", [5.0, 1e6, 1e10, -20.0, -1e9])
def test_a_clock_that_goes_on_alone_takes_over(leap: float):
    times = np.concatenate([TIMES, TIMES + TIMES[-1] + leap])
    assert believed(times) == (times.tolist(), Counter(), 2)


def test_what_is_a_little_back_is_late():
    kept, counts, _ = believed([*TIMES, *(TIMES + DT / 2), TIMES[-1] + DT])
    assert counts == {"late": 199}
    assert kept == [*TIMES, TIMES[-1] + DT / 2, TIMES[-1] + DT]
    assert TIMES[-1] < LATE


@pytest.mark.parametrize("unit", [1e3, 1e6, 1e9, 1 / 60e3, 1 / 3600e3, 1e-300])
def test_times_in_another_unit_are_counted(unit: float):
    kept, counts, _ = believed(unit * (1.7e9 + TIMES))
    assert not kept
    assert set(counts) <= {"foreign", "late", "averaged"}


@pytest.mark.slow
def test_a_kilohertz_is_taken_in_and_no_more():
    t = np.arange(20_000) / 10_000
    kept, counts, _ = believed(1e9 + t)
    assert len(kept) + counts["averaged"] == t.size
    assert len(kept) == 2001
    assert believed(1e9 + t[::10])[1] == {}


def test_times_at_random_wait_for_nothing():
    times = np.random.default_rng(0).uniform(-1e9, 1e9, 1000)
    kept, counts, _ = believed(times)
    assert not kept
    assert counts == {"foreign": 1000 - CLOCKS}


def test_a_sender_is_found_among_times_at_random():
    wrong = np.random.default_rng(0).uniform(-1e9, 1e9, TIMES.size)
    kept, _, _ = believed(alternating(TIMES, wrong))
    assert kept == TIMES.tolist()
    assert len(kept) > WARM_UP


def test_the_average_of_attitudes_and_of_velocities_that_lack():
    clocks = StreamClocks(slice(1, 3))
    first = np.array([0.0, 0.6, 0.8, np.nan, np.nan])
    second = np.array([0.1, -0.6, -0.8, 3.0, np.nan])
    third = np.array([0.2, 0.6, 0.8, np.nan, np.nan])
    mean = clocks.averaged(first, second, 2)
    np.testing.assert_array_equal(mean, [0.05, 0.6, 0.8, 3.0, np.nan])
    mean = clocks.averaged(mean, third, 3)
    np.testing.assert_allclose(mean, [0.1, 0.6, 0.8, 3.0, np.nan])
