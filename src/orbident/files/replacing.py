"""Writing a file, or several of a folder, all or nothing, and by one process at a time.

Locks end with the process that holds them, however it ends.

A block that fails undoes what it has begun. A thread that ends the process does not
wait for that: it undoes what is unfinished, and nothing new appears, nor is anything
finished, from then on.

Several new files are written into a hidden folder inside theirs. Once all are on the
disk, a file `ready` appears there, which commits them: from then on they are the
folder's, and what remains is to move them to their places. A process that is killed
before leaves the old files as they were, one that is killed later the moves, which
whoever reads or writes the folder next makes up for.
"""

import errno
import os
import shutil
import sys
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from pathlib import Path

from orbident.errors import InputError
from orbident.files.text import read_text, reason_of


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


def write_text(path: Path, text: str) -> None:
    """Writes a file, or replaces it, whole or not at all.

    Raises:
        InputError: the folder does not exist, `path` is a folder, or the system
            refuses to write there.
    """
    with replacing(path) as temporary:
        temporary.write_bytes(text.encode())


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


def flush(path: Path, flags: int = os.O_RDWR) -> None:
    """Wait until a file's bytes are on the disk.

    Raises:
        OSError: they did not get there.
    """
    handle = os.open(path, flags)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def flush_names(folder: Path) -> None:
    """Wait until the names in a folder are on the disk, where the system can."""
    with suppress(OSError):
        flush(folder, os.O_RDONLY)


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
