"""Blocks of rows as files, against what the reader of recordings finds."""

import numpy as np
import pytest

from orbident.errors import InputError
from orbident.recordings.tables import read_recording, write_blocks


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_blocks_follow_one_another(tmp_path, suffix):
    table = np.random.default_rng(0).normal(size=(1000, 3))
    table[:, 0] = np.arange(1000) / 7
    table[5:9, 1] = np.nan
    path = tmp_path / f"r{suffix}"
    write_blocks(path, ["t", 'a "b",c', "d"], np.split(table, [1, 300, 301]))
    recording = read_recording(path)
    np.testing.assert_array_equal(recording.t, table[:, 0])
    np.testing.assert_array_equal(recording.columns['a "b",c'], table[:, 1])
    np.testing.assert_array_equal(recording.columns["d"], table[:, 2])


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_a_failure_leaves_what_was_there(tmp_path, suffix):
    path = tmp_path / f"r{suffix}"
    path.write_text("before")

    def blocks():
        yield np.zeros((3, 2))
        raise InputError("the bag is damaged")

    with pytest.raises(InputError, match="the bag is damaged"):
        write_blocks(path, ["t", "a"], blocks())
    assert path.read_text() == "before"
    assert list(tmp_path.iterdir()) == [path]
