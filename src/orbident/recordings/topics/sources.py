"""Files with topics, of any kind, open for reading."""

from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING

from orbident.errors import InputError
from orbident.files.pipes import refuse_pipe
from orbident.recordings.logs.log import KINDS, is_log, open_log

if TYPE_CHECKING:
    from orbident.recordings.bags.bag import Bag
    from orbident.recordings.logs.log import Log

_BAGS = (".bag", ".mcap", ".db3")


def open_source(path: Path) -> "AbstractContextManager[Bag | Log]":
    """A bag or a file of tables; the suffix says which.

    Raises:
        InputError: There is none, its suffix is unknown, it is damaged or empty, or
            the library that reads it is not installed.
    """
    if not path.exists():
        raise InputError(f"{path}: does not exist; check the path")
    refuse_pipe(path, "the recording")
    if is_log(path):
        return open_log(path)
    if path.suffix.lower() not in _BAGS and not path.is_dir():
        known = [*_BAGS, *(suffix for kind in KINDS for suffix in kind.suffixes)]
        raise InputError(
            f"{path}: what can be read is a file whose name ends in one of "
            f"{', '.join(known)}, or the folder of a ROS 2 bag or of NASA's 42"
        )
    # Late, because its libraries are an extra.
    from orbident.recordings.bags.bag import open_bag

    return open_bag(path)
