import os
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


def test_what_a_killed_process_left_is_taken_over(tmp_path):
    path = tmp_path / "a.txt"
    (tmp_path / ".a.txt.orbident-unfinished").write_text("long and half-written")
    write(path)
    assert path.read_text() == "new"
    assert list(tmp_path.iterdir()) == [path]


def test_two_writers(tmp_path):
    """The second is refused, and does not disturb the first."""
    path = tmp_path / "a.txt"
    with replacing(path) as temporary:
        temporary.write_text("first")
        with pytest.raises(InputError, match="another orbident process is writing"):
            write(path)
    assert path.read_text() == "first"
    write(path)
    assert path.read_text() == "new"
    assert list(tmp_path.iterdir()) == [path]


def test_links(tmp_path):
    """What a link leads to is replaced, not the link."""
    (tmp_path / "far").mkdir()
    path, link = tmp_path / "far" / "a.txt", tmp_path / "link"
    link.symlink_to(path)
    for content in ("old", "new"):
        write(link, content)
        assert link.is_symlink()
        assert path.read_text() == content
    itself = tmp_path / "itself"
    itself.symlink_to(itself)
    write(itself)
    assert itself.read_text() == "new"


def test_a_pipe_of_the_shell(tmp_path):
    """As with `--json >(jq .mass)`: what it leads to has no place."""
    reader, writer = os.pipe()
    write(Path(f"/dev/fd/{writer}"))
    assert os.read(reader, 9) == b"new"
    os.close(reader)
    os.close(writer)
