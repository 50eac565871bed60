"""Samples as they come, late, missing, repeated or absurd, and however grouped."""

import copy
import itertools

import numpy as np
import pytest
from live_streams import VELOCITY_STD, csv_lines, robot, samples

from orbident.errors import InputError
from orbident.live.live_filter import LiveEvent, LiveFilter
from orbident.live.rate_smoothing import HALF
from orbident.live.session import nothing_carried, read_state, save_state
from orbident.live.sources import Lines
from orbident.model.minimal_sets import minimal_sets

EVERY = 5.0


def table(captured_at: float | None = None) -> np.ndarray:
    return Lines(robot(), "stream").take(csv_lines(samples(captured_at)))[0]


def fresh() -> LiveFilter:
    return LiveFilter(robot(), VELOCITY_STD, EVERY, nothing_carried(robot()))


def last(filter_: LiveFilter) -> LiveEvent:
    estimate = filter_.estimate()
    assert estimate is not None
    return estimate


def values(told: list[LiveEvent]) -> list[tuple]:
    """All but the counts: these are of samples that have come, not of those taken."""
    return [
        (e.kind, e.t, {name: x for name, x in e.of.items() if name != "counts"})
        for e in told
    ]


def deviations_off(estimate: LiveEvent) -> np.ndarray:
    """Errors of all parameters, over their deviations."""
    true = minimal_sets(robot()).beta(robot().theta)
    return (np.array(estimate.of["beta"]) - true) / np.array(estimate.of["std"])


def check_right(filter_: LiveFilter) -> None:
    estimate = last(filter_)
    # Of 18 parameters one beyond 4 deviations has a probability of 0.1 %.
    assert np.abs(deviations_off(estimate)).max() < 4
    assert estimate.of["std"][0] < 5
    assert estimate.of["scale"]


def test_a_stream_gives_every_parameter():
    filter_ = fresh()
    told = filter_.take(table())
    assert [event.kind for event in told] == 5 * ["estimate"]
    assert [event.t for event in told] == [5.0, 10.0, 15.0, 20.0, 25.0]
    check_right(filter_)
    counts = filter_.carried.counts
    # Half a second at 20 Hz; at the end as much waits, and what tells spikes.
    assert +counts == {"counted": 579, "unsmoothed": 10}
    assert len(filter_.carried.held) == 12


def test_a_capture_is_told():
    told = fresh().take(table(15.0))
    (change,) = [event for event in told if event.kind == "change"]
    assert 15.0 < change.t < 15.2
    assert told[-1].of["beta"][0] == pytest.approx(
        robot().mass + 30.0, abs=4 * told[-1].of["std"][0]
    )


def spoilt() -> tuple[np.ndarray, dict[str, int]]:
    """A stream with every kind of bad sample, and what has to be counted."""
    rows = list(table())
    missing, repeated, absurd, spike, time = (rows[k].copy() for k in range(200, 205))
    missing[3] = np.nan
    repeated[0] += 0.01
    absurd[5] = 1e9
    spike[7] = 100.0  # the gyro's, rad/s: possible and wrong
    time[0] = 1e6
    nameless = rows[300].copy()
    nameless[0] = np.nan
    late = rows[390].copy()
    made: list[np.ndarray] = []
    for k, row in enumerate(rows):
        if k in {200, 202}:
            made.append(missing if k == 200 else absurd)
        elif k == 250:
            made += [np.concatenate([[row[0]], spike[1:]])]
        else:
            made.append(row)
        if k == 201:
            made.append(repeated)
        if k == 300:
            made.append(nameless)
        if k == 310:
            made.append(time)
        if k == 400:
            made.append(late)
    counts = {"missing": 2, "absurd": 1, "foreign": 1, "late": 1}
    counts |= {"repeated": 1, "spikes": 1}
    return np.array(made), counts


def test_bad_samples_are_counted_and_survived():
    rows, expected = spoilt()
    filter_ = fresh()
    told = filter_.take(rows)
    assert {event.kind for event in told} == {"estimate"}
    counts = filter_.carried.counts
    assert {name: counts[name] for name in expected} == expected
    check_right(filter_)


@pytest.mark.parametrize("groups", ["one", "some"])
def test_grouping_does_not_matter(groups: str):
    rows, _ = spoilt()
    whole, parts = fresh(), fresh()
    expected = whole.take(rows.copy())
    ends = range(1, len(rows) + 1) if groups == "one" else [3, 77, 78, 203, len(rows)]
    told = []
    for start, end in itertools.pairwise([0, *ends]):
        told += parts.take(rows[start:end].copy())
    assert values(told) == values(expected)
    assert last(parts) == last(whole)


def test_what_is_averaged_does_not_depend_on_grouping():
    """Two samples in each of 300 milliseconds."""
    rows = table()[:600]
    rows[:, 0] = np.add.outer(0.005 * np.arange(300), [0.0, 0.0002]).ravel()
    whole, parts, moved = fresh(), fresh(), fresh()
    whole.take(rows.copy())
    for start, end in itertools.pairwise([0, 31, 300, 301, 512, 513, 600]):
        parts.take(rows[start:end].copy())
    moved.take(rows + 1e9 * np.eye(1, rows.shape[1]))
    assert last(parts) == last(whole)
    assert last(moved).of == last(whole).of
    np.testing.assert_array_equal(parts.carried.held, whole.carried.held)
    counts = whole.carried.counts
    assert counts["averaged"] == 300
    assert sum(counts.values()) + whole.carried.waiting == 600


def test_a_clock_that_was_set_back():
    rows = table()
    again = rows.copy()
    rows[:, 0] += 1000.0
    filter_ = fresh()
    told = filter_.take(np.vstack([rows[:300], again]))
    (clock,) = [event for event in told if event.kind == "clock"]
    assert clock.t == 0.0
    check_right(filter_)


@pytest.mark.parametrize("zero", [1.0, -0.3, 1e3, 1.7e9])
def test_the_zero_of_time_does_not_matter(zero: float):
    rows = table()[:300]
    here, there = fresh(), fresh()
    here.take(rows.copy())
    rows[:, 0] += zero
    told = there.take(rows)
    assert last(there).of == last(here).of
    assert told[0].t == pytest.approx(zero + EVERY, abs=1e-6)


@pytest.mark.parametrize("apart", [100.0, 3.0])
def test_of_two_senders_one_counts(apart: float):
    rows = table()
    copies = rows.copy()
    copies[:, 0] += apart
    both = np.stack([rows, copies], axis=1).reshape(-1, rows.shape[1])
    alone, among = fresh(), fresh()
    expected, told = alone.take(rows), among.take(both)
    assert values(told) == values(expected)
    assert among.carried.counts["foreign"] == len(rows) - 1


@pytest.mark.parametrize("leap", [2e9, -2e9])
def test_a_clock_that_is_set(leap: float):
    rows = table()
    rows[300:, 0] += leap
    filter_ = fresh()
    told = filter_.take(rows)
    (clock,) = [event for event in told if event.kind == "clock"]
    assert (clock.t, clock.of["before"]) == (15.0 + leap, pytest.approx(14.95, abs=1.0))
    assert (+filter_.carried.counts).keys() == {"counted", "unsmoothed"}
    check_right(filter_)


def test_an_interrupt_leaves_what_was_carried(monkeypatch: pytest.MonkeyPatch):
    filter_, rows = fresh(), table()
    filter_.take(rows[:200].copy())
    before = copy.deepcopy(filter_.carried.counts)
    expected = last(filter_)
    with monkeypatch.context() as patched:
        patched.setattr(LiveFilter, "estimate", interrupted)
        with pytest.raises(KeyboardInterrupt):
            filter_.take(rows[200:400].copy())
    assert (last(filter_), filter_.carried.counts) == (expected, before)
    assert filter_.carried.waiting == 12


def interrupted(_: LiveFilter) -> None:
    raise KeyboardInterrupt


def test_no_mass_is_negative():
    """Rates of the wrong sign: what it finds is wrong, but no number is impossible."""
    rows = table()
    rows[:, 1:] *= -1
    filter_ = fresh()
    told = filter_.take(rows)
    assert "restart" in {event.kind for event in told}
    assert all(event.of.get("beta", [1.0])[0] > 0 for event in told)


def test_a_pause():
    rows = table()
    rows[300:, 0] += 100.0
    filter_ = fresh()
    filter_.take(rows)
    counts = filter_.carried.counts
    assert counts["unsmoothed"] == pytest.approx(30, abs=3)
    check_right(filter_)


def test_a_filter_that_is_lost_begins_anew():
    """Its numbers are finite, and overflow at the next step."""
    rows = table()
    filter_ = fresh()
    filter_.take(rows[:100])
    running = filter_.carried.running
    assert running is not None
    numbers = running.state.numbers
    numbers[40:] = 1e300  # the factors and the estimate
    broken = running._replace(state=running.tools.kalman.core.restored(numbers))
    filter_.carried.running = broken
    told = filter_.take(rows[100:])
    assert "restart" in {event.kind for event in told}
    assert np.isfinite(last(filter_).of["beta"]).all()


@pytest.mark.parametrize("cut", [10, 60, 253, 254, 400])
def test_a_restart_goes_on_with_the_same_bits(cut: int, tmp_path):
    rows, _ = spoilt()
    whole, first = fresh(), fresh()
    expected = whole.take(rows.copy())
    told = first.take(rows[:cut].copy())
    save_state(tmp_path / "state", first.carried)
    carried = read_state(tmp_path / "state", robot(), VELOCITY_STD)
    second = LiveFilter(robot(), VELOCITY_STD, EVERY, carried)
    told += second.take(rows[cut:].copy())
    assert values(told) == values(expected)
    assert last(second) == last(whole)


def test_a_state_of_another_filter_is_refused(tmp_path):
    filter_ = fresh()
    filter_.take(table()[:100])
    path = tmp_path / "state"
    save_state(path, filter_.carried)
    with pytest.raises(InputError, match="another robot, or of other sensors"):
        read_state(path, robot(), 2 * VELOCITY_STD)
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    with pytest.raises(InputError, match="is damaged"):
        read_state(path, robot(), VELOCITY_STD)


def test_half_a_second_is_what_an_estimate_is_late():
    filter_ = fresh()
    rows = table()
    filter_.take(rows)
    assert rows[-1, 0] - last(filter_).t == pytest.approx(HALF + 0.1)
