"""A bag of any kind, open for reading."""

from collections.abc import Collection, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path

from orbident.errors import InputError
from orbident.files.names import one_line
from orbident.recordings.bags.mcap_file import open_mcap
from orbident.recordings.bags.ros1_file import open_ros1
from orbident.recordings.bags.ros2_folder import open_ros2, open_ros2_folder
from orbident.recordings.source import RawMessage, Source

_FILES = {".bag": open_ros1, ".mcap": open_mcap, ".db3": open_ros2}
_REPAIRS = {
    ".bag": "rosbag reindex",
    ".mcap": "mcap recover",
    "": "ros2 bag reindex",
}


@contextmanager
def open_bag(path: Path) -> Iterator[Source]:
    """A ROS 1 bag, a ROS 2 bag (folder or .db3 file), or a bare MCAP file, that exists.

    Raises:
        InputError: it is none, it is damaged, or it has no messages.
    """
    opening = _opening(path)
    with ExitStack() as stack:
        try:
            source = stack.enter_context(opening)
        except InputError:
            raise
        except PermissionError as error:
            raise InputError(
                f"{path}: cannot be read ({error.strerror or error})"
            ) from error
        except Exception as error:
            raise InputError(_damaged(path, error)) from error
        if not any(topic.count for topic in source.topics.values()):
            raise InputError(f"{path}: holds no messages; record again")

        def messages(names: Collection[str]) -> Iterator[RawMessage]:
            # What the libraries raise over damaged bytes is of any kind.
            try:
                stored = iter(source.messages(names))
                while (message := next(stored, None)) is not None:
                    yield message
            except Exception as error:
                raise InputError(_damaged(path, error)) from error

        yield replace(source, messages=messages)


def _opening(path: Path) -> AbstractContextManager[Source]:
    if path.is_dir():
        return open_ros2_folder(path)
    if path.stat().st_size == 0:
        raise InputError(f"{path}: is empty; record again")
    return _FILES[path.suffix.lower()](path)


def _damaged(path: Path, error: Exception) -> str:
    repair = _REPAIRS.get(path.suffix.lower(), _REPAIRS[""])
    return (
        f"{path}: is damaged or no bag of this kind ({one_line(error)}); "
        f"copy it again, or repair it with '{repair}'"
    )
