"""Replacing several files of a folder at once: all of them or none.

New files are written into a hidden folder inside it. Once all are on the disk, a file
`ready` appears there, which commits them: from then on they are the folder's, and what
remains is to move them to their places. A process that is killed before leaves the old
files as they were, one that is killed later the moves, which whoever reads or writes
the folder next makes up for.
"""

import shutil
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path

from orbident.errors import InputError
from orbident.files.replacing import (
    CHANGING,
    UNFINISHED,
    flush,
    flush_names,
    locked,
    reason_of,
    undone,
    writing,
)
from orbident.files.text import read_text, write_text

STAGED = f".{UNFINISHED}"
_READY = "ready"
"""Holds the names of what is to be removed, one a line."""


@contextmanager
def replacing_files(folder: Path, ours: Sequence[str]) -> Iterator[Path]:
    """A folder for new files, which take the place of `ours` if the block succeeds.

    The folder is made if it is missing, and gone again if the block fails. The paths
    `ours` are put in place in their order, and removed where the block does not write
    them; all else in the folder stays untouched.

    Raises:
        InputError: the system refuses to write there, or another process is doing so.
    """
    missing = [above for above in (folder, *folder.parents) if not above.exists()]
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
        with locked(folder):
            _put_in_place(folder, ours)
            staged = folder / STAGED
            with undone(partial(_remove, folder, missing)):
                shutil.rmtree(staged, ignore_errors=True)
                with CHANGING:
                    staged.mkdir()
                yield staged
                _commit(folder, ours)
        finish(folder, ours)


def finish(folder: Path, ours: Sequence[str]) -> None:
    """Put in place what a process committed there before it was ended, if one did.

    Raises:
        InputError: the system does not allow it.
    """
    try:
        if is_committed(folder):
            with locked(folder, wait=True):
                _put_in_place(folder, ours)
    except OSError as error:
        raise InputError(
            f"{folder}: its new files are complete, but cannot be put in place "
            f"({reason_of(error)}); do this as a user who may write there"
        ) from error


def is_committed(folder: Path) -> bool:
    """Whether complete new files wait to be put in place."""
    return (folder / STAGED / _READY).is_file()


def is_unfinished(folder: Path) -> bool:
    """Whether new files were being written there, now or when a process was ended."""
    return (folder / STAGED).is_dir()


def _remove(folder: Path, made: Sequence[Path]) -> None:
    """Remove new files that are not committed, and what was made for them."""
    if not is_committed(folder):
        shutil.rmtree(folder / STAGED, ignore_errors=True)
        for each in made:
            with suppress(OSError):
                each.rmdir()


def _commit(folder: Path, ours: Sequence[str]) -> None:
    staged = folder / STAGED
    new = {name for name in ours if (staged / name).is_file()}
    for name in sorted(ours):
        if (folder / name).is_dir():
            raise InputError(
                f"{folder / name}: is a folder where a file belongs; move it away"
            )
    for name in new:
        flush(staged / name)
    _flush_names(staged, new)
    with CHANGING:
        write_text(staged / _READY, "\n".join(sorted(set(ours) - new)))
    flush_names(staged)


def _put_in_place(folder: Path, ours: Sequence[str]) -> None:
    """Begin, or go on with, the moves; nothing where nothing is committed."""
    if not is_committed(folder):
        return
    staged = folder / STAGED
    for name in set(ours).intersection(read_text(staged / _READY).splitlines()):
        (folder / name).unlink(missing_ok=True)
    for name in ours:
        if (staged / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (staged / name).replace(folder / name)
    _flush_names(folder, ours)
    (staged / _READY).unlink()
    shutil.rmtree(staged)


def _flush_names(folder: Path, names: Iterable[str]) -> None:
    for parent in {folder, *((folder / name).parent for name in names)}:
        flush_names(parent)
