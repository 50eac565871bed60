"""Writing a file whole or not at all."""

import os
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from pathlib import Path

from orbident.errors import InputError
from orbident.files.locking import busy, has_locked
from orbident.files.unfinished import CHANGING, undone
from orbident.files.writing import writing

UNFINISHED = "orbident-unfinished"
"""How the hidden names end that a file or a folder has until it is complete."""


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A temporary path in the same folder, moved to `path` if the block succeeds.

    Its bytes are on the disk before it is moved. What a killed process has left there
    is overwritten: a path has one temporary name, which its writer has locked.

    Raises:
        InputError: the folder does not exist, `path` is a folder, the system refuses
            to write there, or another process is doing so.
    """
    check_place(path)
    with writing(path):
        if path.exists() and not path.is_file():
            # A pipe or a device takes what is written; it is not to be replaced.
            yield path
            return
        # Unlike Path.resolve it takes links that lead to themselves.
        target = Path(os.path.realpath(path))
        temporary = target.with_name(f".{target.name}.{UNFINISHED}")
        with ExitStack() as opened:
            with CHANGING:
                _reserve(temporary, path, opened)
                # Closed, in reverse, before the lock is given up.
                opened.enter_context(undone(partial(temporary.unlink, missing_ok=True)))
            yield temporary
            flush(temporary)
            temporary.replace(target)


def check_place(path: Path) -> None:
    """Refuse a place for a file.

    Raises:
        InputError: it is a folder, or in a folder that does not exist.
    """
    if not path.parent.is_dir():
        raise InputError(f"{path}: folder '{path.parent}' does not exist; create it")
    if path.is_dir():
        raise InputError(f"{path}: is a folder; give a file name")


def check_free(path: Path, force: bool) -> None:
    """Refuse to replace a file that holds something, unless it is wanted.

    Raises:
        InputError: there is such a file and `force` is false, or this is no place for
            a file.
    """
    check_place(path)
    # A pipe or a device is not replaced; in an empty file there is nothing to lose.
    if not force and path.is_file() and path.stat().st_size:
        raise InputError(f"{path}: exists already; name another, or use --force")


def flush(path: Path) -> None:
    """Wait until a file's bytes are on the disk.

    Raises:
        OSError: they did not get there.
    """
    handle = os.open(path, os.O_RDWR)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def flush_names(folder: Path) -> None:
    """Wait until the names in a folder are on the disk, where the system can."""
    with suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def _reserve(temporary: Path, path: Path, opened: ExitStack) -> None:
    """Make the temporary file, and lock it until `opened` is closed."""
    while True:
        flags = os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0)
        handle = os.open(temporary, flags, 0o666)
        opened.callback(os.close, handle)
        if not has_locked(handle):
            raise InputError(busy(path))
        # Until the lock was ours another writer may have moved or removed the file.
        with suppress(FileNotFoundError):
            if os.path.samestat(os.fstat(handle), temporary.lstat()):
                return
