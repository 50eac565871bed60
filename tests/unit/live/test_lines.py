"""Lines of CSV and JSON."""

import numpy as np
import pytest
from live_streams import csv_lines, json_lines, robot, samples

from orbident.live.sources import Lines, needed_columns


def read(lines: list[bytes]) -> tuple[np.ndarray, int]:
    return Lines(robot(), "stream").take(lines)


def test_csv_and_json_say_the_same():
    columns = samples()
    from_csv, _ = read(csv_lines(columns))
    from_json, _ = read(json_lines(columns))
    np.testing.assert_array_equal(from_csv, from_json)
    np.testing.assert_array_equal(from_csv[:, 0], columns["t"])
    np.testing.assert_array_equal(from_csv[:, -1], columns["gyro.z"])
    np.testing.assert_array_equal(from_csv[:, -4], columns["velocity.z"])


def test_columns_may_stand_anywhere():
    columns = samples()
    turned = {"note": columns["t"], **dict(reversed(columns.items()))}
    np.testing.assert_array_equal(
        read(csv_lines(turned))[0], read(csv_lines(columns))[0]
    )


def test_text_in_a_column_of_nobody_is_not_read():
    header, *lines = csv_lines(samples())[:5]
    rows, unreadable = read([header + b",mode", *(line + b",hold" for line in lines)])
    assert (len(rows), unreadable) == (4, 0)


def test_what_is_no_sample_is_counted():
    header, *lines = csv_lines(samples())[:5]
    cut, word = lines[0][: len(lines[0]) // 2], b"temperature high"
    deep, long = 10_000 * b'{"t":', b'{"t": ' + 400 * b"9" + b"}"
    rows, unreadable = read(
        [lines[0], word, header, cut, word, b"", *lines, b"{", b"[]", deep, long]
    )
    assert len(rows) == 4
    assert unreadable == 8


def test_a_cell_may_be_empty():
    columns = {name: column[:3].copy() for name, column in samples().items()}
    columns["gyro.y"][1] = np.nan
    for lines in (csv_lines(columns), json_lines(columns)):
        rows, unreadable = read(lines)
        assert unreadable == 0
        assert np.isnan(rows[1]).sum() == 2  # with less noise it is the same column


@pytest.mark.parametrize("lines", [csv_lines, json_lines])
def test_a_lacking_column_is_named(lines):
    columns = {n: c[:3] for n, c in samples().items() if n != "joint.joint2.velocity"}
    reader = Lines(robot(), "stream")
    rows, unreadable = reader.take(lines(columns)[:2])
    assert (len(rows), unreadable) == (0, 2)
    assert "no column 'joint.joint2.velocity'" in reader.lacking
    assert len(reader.take(csv_lines(samples())[:5])[0]) == 4


def test_a_second_header_that_lacks_columns_changes_nothing():
    header, *lines = csv_lines(samples())[:5]
    rows, unreadable = read([header, lines[0], b"t,gyro.x", *lines[1:]])
    assert (len(rows), unreadable) == (4, 1)


def test_the_columns_that_are_needed():
    assert len(needed_columns(robot())) == 1 + 2 * 3 + 3 + 4 + 3
