"""Several files replaced at once; kills are in `tests/faults`."""

import errno
import os
from pathlib import Path

import pytest

from orbident.errors import InputError
from orbident.files.replacing import (
    STAGED,
    finish,
    is_committed,
    is_unfinished,
    replacing_files,
    write_text,
)

OURS = ("a", "below/b", "c")


def put(folder: Path, **files: str) -> None:
    with replacing_files(folder, OURS) as new:
        for name, content in files.items():
            path = new / name.replace("_", "/")
            path.parent.mkdir(exist_ok=True)
            path.write_text(content)


def contents(folder: Path) -> dict[str, str]:
    files = (path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): path.read_text() for path in files}


def test_ours_are_replaced_and_others_stay(tmp_path):
    folder = tmp_path / "deep" / "er"
    put(folder, a="1", below_b="2")
    (folder / "notes").write_text("mine")
    (folder / "below" / "mine").write_text("too")
    put(folder, a="3", c="4")
    mine = {"notes": "mine", "below/mine": "too"}
    assert contents(folder) == {"a": "3", "c": "4", **mine}


def test_what_is_not_ours_is_never_put_in_place(tmp_path):
    with replacing_files(tmp_path, OURS) as new:
        (new / "other").write_text("x")
    assert contents(tmp_path) == {}


def test_a_failed_block_changes_nothing(tmp_path):
    folder = tmp_path / "deep" / "er"
    with pytest.raises(ZeroDivisionError):
        _fail(folder)
    assert list(tmp_path.iterdir()) == []
    put(folder, a="1", c="2")
    with pytest.raises(ZeroDivisionError):
        _fail(folder)
    assert contents(folder) == {"a": "1", "c": "2"}
    assert not is_unfinished(folder)


def _fail(folder: Path) -> None:
    with replacing_files(folder, OURS) as new:
        (new / "a").write_text("half")
        raise ZeroDivisionError


def test_a_refusal_names_the_folder(tmp_path):
    """Not the hidden one, which is gone."""
    folder = tmp_path / "RUN"
    with (
        pytest.raises(
            InputError, match=r"RUN: cannot be written \(No space left .*free"
        ),
        replacing_files(folder, OURS) as new,
    ):
        _full(new / "a")
    assert list(tmp_path.iterdir()) == []


def _full(path: Path) -> None:
    write_text(path, "")
    raise OSError(errno.ENOSPC, "words of a library")


def test_a_folder_where_a_file_belongs(tmp_path):
    (tmp_path / "c").mkdir()
    with pytest.raises(InputError, match="c: is a folder where a file belongs"):
        put(tmp_path, a="1")
    assert contents(tmp_path) == {}


def test_two_writers(tmp_path):
    with replacing_files(tmp_path, OURS) as new:
        (new / "a").write_text("first")
        with pytest.raises(InputError, match="another orbident process is writing"):
            put(tmp_path, a="second")
    assert contents(tmp_path) == {"a": "first"}


def test_committed_files_are_put_in_place_later(tmp_path):
    """What is left by a process that was killed after the moves began."""
    put(tmp_path, a="old", below_b="old")
    staged = tmp_path / STAGED
    staged.mkdir()
    (staged / "c").write_text("new")
    (staged / "stray").write_text("new")
    finish(tmp_path, OURS)
    assert contents(tmp_path)["a"] == "old"
    # Only what is ours is removed, whatever is asked for.
    (tmp_path / "mine").write_text("mine")
    (staged / "ready").write_text("a\nmine\n../..")
    assert is_committed(tmp_path)
    finish(tmp_path, OURS)
    assert contents(tmp_path) == {"below/b": "old", "c": "new", "mine": "mine"}
    assert not is_unfinished(tmp_path)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_committed_files_of_somebody_else(tmp_path):
    staged = tmp_path / STAGED
    staged.mkdir()
    (staged / "ready").write_text("")
    tmp_path.chmod(0o500)
    with pytest.raises(InputError, match="as a user who may write there"):
        finish(tmp_path, OURS)
    tmp_path.chmod(0o700)
