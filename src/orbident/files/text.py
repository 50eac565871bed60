"""Reading files: text in UTF-8, line ends untouched, and checksums."""

import hashlib
import os
from pathlib import Path
from stat import S_ISDIR, S_ISREG

from orbident.errors import InputError
from orbident.files.names import one_line

MOST = 2**28
"""Bytes of a text file: a device without an end would fill the memory."""


def read_text(path: Path) -> str:
    """The text of a file, without a byte order mark.

    Raises:
        InputError: the file is missing, a folder, unreadable, too long or not UTF-8.
    """
    try:
        with path.open("rb") as file:
            content = file.read(MOST + 1)
        text = content.decode("utf-8-sig")
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; check the path") from None
    except UnicodeDecodeError as error:
        raise InputError(
            f"{path}: byte {error.start} is not UTF-8 text; give a text file in UTF-8"
        ) from None
    except IsADirectoryError:
        raise InputError(f"{path}: is a folder; give a file") from None
    except OSError as error:
        raise unreadable(path, error) from error
    except ValueError as error:
        # A path with a null byte.
        raise InputError(f"{str(path)!r}: cannot be read ({error})") from None
    if len(content) > MOST:
        raise InputError(
            f"{path}: has more than {MOST // 2**20} MiB of text; give a file of the "
            "kind that is asked for"
        )
    return text


def name_of(path: Path) -> str:
    r"""A file's name as UTF-8 text, in which a byte that is none is shown as `\xff`."""
    return os.fsencode(path.name).decode(errors="backslashreplace")


def sha256(path: Path) -> str:
    """The file's SHA-256, hexadecimal.

    Raises:
        InputError: it cannot be read.
    """
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise unreadable(path, error) from error


def unreadable(path: Path, error: OSError) -> InputError:
    """What is said where the system refuses to read."""
    return InputError(f"{path}: cannot be read ({reason_of(error)})")


def reason_of(error: OSError) -> str:
    """The system's words alone: libraries put their own before them."""
    return os.strerror(error.errno) if error.errno else one_line(error)


def refuse_pipe(path: Path, what: str) -> None:
    """Refuse a pipe or a device, and nothing else, where "the recording" is wanted.

    Raises:
        InputError: it is one.
    """
    try:
        mode = path.stat().st_mode
    # What is no path at all has its own words where it is opened.
    except (OSError, ValueError):
        return
    if not (S_ISREG(mode) or S_ISDIR(mode)):
        raise InputError(
            f"{path}: is a pipe or a device, which cannot be read twice; write {what} "
            "into a file, and give that"
        )
