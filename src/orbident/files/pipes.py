"""Pipes and devices, where a file is wanted that can be read twice."""

from pathlib import Path
from stat import S_ISDIR, S_ISREG

from orbident.errors import InputError


def refuse_pipe(path: Path, what: str) -> None:
    """Refuse a pipe or a device, and nothing else.

    Args:
        path: any.
        what: is to be read: "the recording".

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
