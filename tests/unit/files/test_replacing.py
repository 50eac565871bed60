from pathlib import Path

import pytest

from orbident.errors import InputError
from orbident.files.replacing import replacing


def write(path, content="new"):
    with replacing(path) as temporary:
        temporary.write_text(content)


def fail_half_way(path):
    with replacing(path) as temporary:
        temporary.write_text("half")
        raise RuntimeError


def test_a_file_is_replaced_whole(tmp_path):
    path = tmp_path / "a.txt"
    for content in ("old and long", "new"):
        write(path, content)
        assert path.read_text() == content
    assert list(tmp_path.iterdir()) == [path]


def test_places_refused(tmp_path):
    with pytest.raises(InputError, match=r"folder '.*nowhere' does not exist; create"):
        write(tmp_path / "nowhere" / "a.txt")
    with pytest.raises(InputError, match="is a folder; give a file name"):
        write(tmp_path)


def test_a_failed_block_leaves_the_old_file(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")
    with pytest.raises(RuntimeError):
        fail_half_way(path)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_refusing_system_is_an_input_error(tmp_path, monkeypatch):
    path = tmp_path / "a.txt"
    path.write_text("old")

    def refuse(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "replace", refuse)
    with pytest.raises(InputError, match=r"cannot be written \(No space left"):
        write(path)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]
