"""Writing a file whole or not at all."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from orbident.errors import InputError


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A temporary path in the same folder, moved to `path` if the block succeeds.

    Raises:
        InputError: the folder does not exist, `path` is a folder, or the system
            refuses to write there.
    """
    if not path.parent.is_dir():
        raise InputError(f"{path}: folder '{path.parent}' does not exist; create it")
    if path.is_dir():
        raise InputError(f"{path}: is a folder; give a file name")
    target = path.resolve()
    temporary = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        if target.exists() and not target.is_file():
            # A pipe or a device takes what is written; it is not to be replaced.
            yield target
        else:
            yield temporary
            temporary.replace(target)
    except OSError as error:
        reason = error.strerror or error
        raise InputError(f"{path}: cannot be written ({reason})") from error
    finally:
        temporary.unlink(missing_ok=True)
