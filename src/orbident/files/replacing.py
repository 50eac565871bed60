"""Writing a file whole or not at all, and by one process at a time.

Locks end with the process that holds them, however it ends.

A block that fails undoes what it has begun. A thread that ends the process does not
wait for that: it undoes what is unfinished, and nothing new appears, nor is anything
finished, from then on.
"""

import errno
import os
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from pathlib import Path

from orbident.errors import InputError


@contextmanager
def locked(folder: Path, wait: bool = False) -> Iterator[None]:
    """No other process of ours writes in the folder during the block.

    The lock is on the folder itself (`flock`), so it leaves no file behind. Where the
    system has no such locks (Windows, some network file systems) there is none. With
    `wait` it waits until whoever has the lock is done.

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


_FULL = "free some space, or name another place"
_FORBIDDEN = "name a place where you may write"
_REMEDIES = {
    errno.ENOSPC: _FULL,
    errno.EDQUOT: _FULL,
    errno.EFBIG: "raise the limit of file sizes (ulimit -f), or name another place",
    errno.EACCES: _FORBIDDEN,
    errno.EPERM: _FORBIDDEN,
    errno.EROFS: _FORBIDDEN,
}


class _WriteError(InputError):
    """The system refused to write; `error` has its own words."""

    def __init__(self, path: Path, error: OSError) -> None:
        remedy = _REMEDIES.get(error.errno or 0, "name another place")
        super().__init__(
            f"{path}: cannot be written ({reason_of(error)}); nothing was changed "
            f"there; {remedy}"
        )
        self.error = error


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Make one line of what the system says while the block writes.

    What the user named is as it was where the block fails. Around another such block it
    is the one that is named.

    Raises:
        InputError: the block raised an `OSError`.
    """
    try:
        yield
    except OSError as error:
        raise _WriteError(path, error) from error
    except _WriteError as refused:
        raise _WriteError(path, refused.error) from refused


def reason_of(error: OSError) -> str:
    """The system's words alone: libraries put their own before them."""
    if error.errno:
        return os.strerror(error.errno)
    return " ".join(str(error).split()) or type(error).__name__


CHANGING = threading.RLock()
"""Held while something temporary appears or becomes final, not while it is filled."""
_PATIENCE = 0.3
"""What such a moment may take before the process ends all the same, s."""
_UNDO: list[Callable[[], None]] = []


@contextmanager
def undone(undo: Callable[[], None]) -> Iterator[None]:
    """Call `undo` if the block fails, or if another thread ends the process during it.

    It may be called twice, and by that thread.
    """
    _UNDO.append(undo)
    try:
        yield
    except BaseException:
        undo()
        raise
    finally:
        _UNDO.remove(undo)


def undo_all() -> None:
    """Undo what is unfinished; the process must end next."""
    CHANGING.acquire(timeout=_PATIENCE)
    for undo in tuple(_UNDO):
        undo()


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
