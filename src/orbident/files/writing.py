"""What is said where the system refuses to write."""

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from orbident.errors import InputError

_REMEDIES = {
    errno.ENOSPC: "free some space, or name another place",
    errno.EDQUOT: "free some space, or name another place",
    errno.EFBIG: "raise the limit of file sizes (ulimit -f), or name another place",
    errno.EACCES: "name a place where you may write",
    errno.EPERM: "name a place where you may write",
    errno.EROFS: "name a place where you may write",
}


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Make one line of what the system says while the block writes.

    Args:
        path: what the user named; the block leaves it as it was where it fails.

    Raises:
        InputError: the block raised an `OSError`.
    """
    try:
        yield
    except OSError as error:
        remedy = _REMEDIES.get(error.errno or 0, "name another place")
        raise InputError(
            f"{path}: cannot be written ({reason_of(error)}); nothing was changed "
            f"there; {remedy}"
        ) from error


def reason_of(error: OSError) -> str:
    """The system's words alone: libraries put their own before them."""
    if error.errno:
        return os.strerror(error.errno)
    return " ".join(str(error).split()) or type(error).__name__
