"""What a file held, as one short text."""

import hashlib
from pathlib import Path

from orbident.errors import InputError


def sha256(path: Path) -> str:
    """The file's SHA-256, hexadecimal.

    Raises:
        InputError: it cannot be read.
    """
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        reason = error.strerror or error
        raise InputError(f"{path}: cannot be read ({reason})") from error
