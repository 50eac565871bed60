"""Locks that end with the process that holds them, however it ends."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from orbident.errors import InputError


@contextmanager
def locked(folder: Path, wait: bool = False) -> Iterator[None]:
    """No other process of ours writes in the folder during the block.

    The lock is on the folder itself (`flock`), so it leaves no file behind. Where the
    system has no such locks (Windows, some network file systems) there is none.

    Args:
        folder: that exists.
        wait: until whoever has the lock is done; else that is refused.

    Raises:
        InputError: another process has the lock.
        OSError: the folder cannot be opened.
    """
    if sys.platform == "win32":
        yield
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        if not has_locked(handle, wait):
            raise InputError(busy(folder))
        yield
    finally:
        os.close(handle)


def has_locked(handle: int, wait: bool = False) -> bool:
    """Whether an open file is locked now; closing it ends that."""
    if sys.platform == "win32":
        return True
    import fcntl

    try:
        fcntl.flock(handle, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except BlockingIOError:
        return False
    except OSError:
        # A file system without locks: that it is alone nobody can know there.
        return True
    return True


def busy(path: Path) -> str:
    """What is said where another process has the lock."""
    return (
        f"{path}: another orbident process is writing there; wait until it has ended, "
        "or name another place"
    )
