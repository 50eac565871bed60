"""Stretches of a recording: every row once, with enough samples beside them."""

from pathlib import Path

import numpy as np
import pytest

from orbident.errors import InputError
from orbident.recordings.long_recording import LARGE, SPAN, LongRecording
from orbident.recordings.recording import Recording
from orbident.recordings.tables import (
    open_recording,
    read_recording,
    write_recording,
)

ROWS = LARGE + 5000


@pytest.fixture(scope="module")
def recording() -> Recording:
    """One with a sensor at a tenth of the rate, which fails for a while."""
    slow = np.full(ROWS, np.nan)
    slow[::10] = np.arange(0, ROWS, 10)
    slow[50_000:53_000] = np.nan
    columns = {"gyro.x": np.arange(ROWS) / 3, "position.x": slow, "mine": slow}
    return Recording(np.arange(ROWS) / 100, columns, "held")


@pytest.fixture(scope="module", params=["memory", "parquet", "csv"])
def long(
    request: pytest.FixtureRequest,
    recording: Recording,
    tmp_path_factory: pytest.TempPathFactory,
) -> LongRecording:
    if request.param == "memory":
        return LongRecording.of(recording)
    path = tmp_path_factory.mktemp("long") / f"long.{request.param}"
    write_recording(recording, path)
    opened = open_recording(path)
    assert isinstance(opened, LongRecording)
    assert opened.rows == ROWS
    return opened


def test_between_is_long_or_in_memory(long: LongRecording, recording: Recording):
    start, end = 12.34, recording.t[-2]
    cut = long.between(start, end)
    assert isinstance(cut, LongRecording)
    t = np.concatenate([batch["t"] for batch in cut.batches()])
    assert np.array_equal(t, recording.between(start, end).t)
    assert np.array_equal(cut.read().t, t)
    assert cut.rows == t.size
    few = long.between(500.0, 510.0)
    assert isinstance(few, Recording)
    wanted = recording.between(500.0, 510.0)
    assert np.array_equal(few.t, wanted.t)
    assert np.array_equal(few.columns["gyro.x"], wanted.columns["gyro.x"])
    with pytest.raises(InputError, match="has 0 rows from -5 s to -1 s; its times are"):
        long.between(-5.0, -1.0)


@pytest.mark.parametrize("size", [10_000, 65_536, ROWS])
def test_every_row_is_one_stretchs_own(
    long: LongRecording, recording: Recording, size: int
):
    wanted = {"t": 100, "gyro.x": 200, "position.x": 50}
    t, first = [], 0
    for stretch, own in long.stretches(wanted.__getitem__, size):
        t.append(stretch.t[own])
        assert set(stretch.columns) == {"gyro.x", "position.x"}
        end = first + t[-1].size
        before, after = stretch.columns["position.x"], recording.columns["position.x"]
        for held, left in (
            (before[: own.start], after[:first]),
            (before[own.stop :], after[end:]),
        ):
            seen, there = (np.count_nonzero(~np.isnan(x)) for x in (held, left))
            assert seen >= min(there, 50)
        # The outage, and what is wanted beside it.
        assert stretch.t.size <= size + 2 * (3000 + 500 + 4096 + SPAN)
        first = end
    np.testing.assert_array_equal(np.concatenate(t), recording.t)


def test_a_digest_is_of_spans_evenly_spread(long: LongRecording, recording: Recording):
    digest = long.digest
    assert digest.t.size == LARGE
    np.testing.assert_array_equal(digest.t[:SPAN], recording.t[:SPAN])
    np.testing.assert_array_equal(digest.t[-SPAN:], recording.t[-SPAN:])
    rows = np.searchsorted(recording.t, digest.t)
    for name, x in digest.columns.items():
        np.testing.assert_array_equal(x, recording.columns[name][rows])


def test_all_of_it_can_be_read(long: LongRecording, recording: Recording):
    read = long.read()
    for name, x in recording.columns.items():
        np.testing.assert_array_equal(read.columns[name], x)


def test_a_short_recording_is_read(recording: Recording, tmp_path: Path):
    rows = slice(LARGE - 1)
    columns = {name: x[rows] for name, x in recording.columns.items()}
    for suffix in ("csv", "parquet"):
        path = tmp_path / f"short.{suffix}"
        write_recording(Recording(recording.t[rows], columns), path)
        opened = open_recording(path)
        assert isinstance(opened, Recording)
        np.testing.assert_array_equal(opened.t, read_recording(path).t)


def test_what_is_wrong_far_on_is_refused_there(recording: Recording):
    t = recording.t.copy()
    t[80_000] = 0.0
    rows = recording.columns["gyro.x"]

    def batches():
        yield {"t": t[:45_000], "gyro.x": rows[:45_000]}
        yield {"t": t[45_000:], "gyro.x": rows[45_000:]}

    long = LongRecording("long.csv", ROWS, batches, lambda: recording)
    stretches = long.stretches(lambda _: 100, 2**16)
    words = r"long.csv, from row 65437 on: column 't', row 14565: 0.0 s does not come"
    with pytest.raises(InputError, match=words):
        list(stretches)


def test_what_is_wrong_is_said_with_where_its_rows_begin(recording: Recording):
    t = recording.t.copy()
    t[85_000] = t[80_000]
    batches = LongRecording.of(recording).batches

    def wrong():
        row = 0
        for batch in batches():
            yield {**batch, "t": t[row : row + batch["t"].size]}
            row += batch["t"].size

    long = LongRecording("held", ROWS, wrong, lambda: recording)
    with pytest.raises(InputError, match=r"held, from row (\d+) on: .*row (\d+): 800"):
        _ = long.digest
    with pytest.raises(InputError, match=r"held.*row .*: 800.0 s does not come"):
        list(long.stretches(lambda _: 100, 2**16))


@pytest.mark.parametrize("spoiled", ["cut off", "text"])
def test_files_that_are_spoiled_far_inside(
    spoiled: str, recording: Recording, tmp_path: Path
):
    path = tmp_path / ("long.parquet" if spoiled == "cut off" else "long.csv")
    write_recording(recording, path)
    content = path.read_bytes()
    if spoiled == "cut off":
        path.write_bytes(content[: len(content) // 2])
    else:
        at = content.index(b"\n", len(content) // 2) + 1
        path.write_bytes(content[:at] + b"late" + content[at:])
    with pytest.raises(InputError, match=r"not a readable Parquet|column 't', row"):
        digest_of(path)


def digest_of(path: Path) -> Recording:
    opened = open_recording(path)
    assert isinstance(opened, LongRecording)
    return opened.digest
