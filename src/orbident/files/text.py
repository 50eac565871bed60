"""Text files in UTF-8, line ends untouched."""

import os
from pathlib import Path

from orbident.errors import InputError
from orbident.files.replacing import replacing

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
        reason = error.strerror or error
        raise InputError(f"{path}: cannot be read ({reason})") from error
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


def write_text(path: Path, text: str) -> None:
    """Writes a file, or replaces it, whole or not at all.

    Raises:
        InputError: the folder does not exist, `path` is a folder, or the system
            refuses to write there.
    """
    with replacing(path) as temporary:
        temporary.write_bytes(text.encode())
