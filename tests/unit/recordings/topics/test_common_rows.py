"""The union of stamps against the obvious loop, and rows read in any order."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orbident.recordings.topics.timing import common_rows
from orbident.recordings.topics.track import RowFile

# A small range, so that sensors often meet within 100 ns.
GAPS = st.lists(st.integers(101, 400), min_size=1, max_size=12)
SENSORS = st.lists(st.tuples(st.integers(0, 500), GAPS), min_size=1, max_size=4)


@given(SENSORS)
def test_rows(sensors):
    stamps = [
        start + np.cumsum(np.array(gaps, dtype=np.int64)) for start, gaps in sensors
    ]
    rows, places = common_rows(stamps)
    assert np.all(np.diff(rows) > 0)
    used = set()
    for each, place in zip(stamps, places, strict=True):
        assert len(set(place.tolist())) == each.size
        assert np.all(np.abs(rows[place] - each) <= 100)
        used |= set(place.tolist())
    assert used == set(range(rows.size))


@given(SENSORS)
def test_a_stamp_joins_a_row_wherever_one_is_free(sensors):
    stamps = [start + 1000 * np.arange(len(gaps)) for start, gaps in sensors]
    rows, places = common_rows(stamps)
    # One stamp at a time: the nearest row within 100 ns, the earlier of two.
    obvious: list[int] = []
    for each in stamps:
        fresh = []
        for stamp in each.tolist():
            near = [row for row in obvious if abs(row - stamp) <= 100]
            if not near:
                fresh.append(stamp)
        obvious = sorted({*obvious, *fresh})
    assert rows.tolist() == obvious
    assert all(
        place.size == each.size for place, each in zip(places, stamps, strict=True)
    )


@pytest.mark.parametrize("order", ["as written", "reversed", "shuffled", "repeated"])
def test_row_file(tmp_path, order):
    table = np.random.default_rng(0).normal(size=(1000, 3))
    file = RowFile(tmp_path / "r.csv", 3)
    file.append(table[:300])
    file.append(table[300:])
    index = {
        "as written": np.arange(1000),
        "reversed": np.arange(1000)[::-1],
        "shuffled": np.random.default_rng(1).permutation(1000),
        "repeated": np.array([5, 5, 4, 999, 5, 0]),
    }[order]
    np.testing.assert_array_equal(file.gather(index), table[index])
    assert file.gather(index[:0]).shape == (0, 3)
    file.close()
