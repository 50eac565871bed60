"""What is said where the system refuses to write."""

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from orbident.errors import InputError

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

    Args:
        path: what the user named; the block leaves it as it was where it fails. Around
            another such block it is the one that is named.

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
