"""Pipes and devices, where a file is wanted that can be read twice."""

from pathlib import Path

from orbident.errors import InputError


def refuse_pipe(path: Path, what: str) -> None:
    """Refuse a pipe or a device; what is missing, or a folder, is not looked at.

    Args:
        path: any.
        what: is to be read: "the recording".

    Raises:
        InputError: it is one.
    """
    if path.exists() and not path.is_file() and not path.is_dir():
        raise InputError(
            f"{path}: is a pipe or a device, which cannot be read twice; write {what} "
            "into a file, and give that"
        )
