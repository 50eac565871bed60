from pathlib import Path

import pytest

from orbident.errors import InputError
from orbident.files.replacing import write_text
from orbident.files.text import read_text


def test_round_trip_keeps_line_ends(tmp_path):
    path = tmp_path / "a.txt"
    write_text(path, "é\r\nb\rc\n")
    assert path.read_bytes() == b"\xc3\xa9\r\nb\rc\n"
    assert read_text(path) == "é\r\nb\rc\n"


def test_a_byte_order_mark_is_dropped(tmp_path):
    path = tmp_path / "a.txt"
    path.write_bytes(b"\xef\xbb\xbfa: 1")
    assert read_text(path) == "a: 1"


def test_bytes_that_are_no_text(tmp_path):
    path = tmp_path / "a.txt"
    path.write_bytes(b"schema: \xff")
    with pytest.raises(InputError, match=r"a\.txt: byte 8 is not UTF-8 text; give a"):
        read_text(path)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("none.txt", r"none\.txt: no such file; check the path"),
        (".", "is a folder; give a file"),
        ("x" * 5000, r"cannot be read \(File name too long\)"),
        ("a\0b", r"cannot be read \(embedded null byte\)"),
    ],
)
def test_places_that_are_no_file(tmp_path, name, message):
    with pytest.raises(InputError, match=message):
        read_text(tmp_path / name)


def test_a_file_that_must_not_be_read(tmp_path, monkeypatch):
    def refuse(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "open", refuse)
    with pytest.raises(InputError, match=r"cannot be read \(Permission denied\)"):
        read_text(tmp_path / "a.txt")


def test_a_file_without_end_is_refused():
    """Not read until the memory is full: found by the fuzzer."""
    with pytest.raises(InputError, match="/dev/zero: has more than 256 MiB of text"):
        read_text(Path("/dev/zero"))
