"""A bag of any kind, open for reading."""

from collections.abc import Collection, Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

from orbident.errors import InputError
from orbident.files.names import closest, listed, one_line
from orbident.recordings.bags.mcap_file import open_mcap
from orbident.recordings.bags.ros1_file import open_ros1
from orbident.recordings.bags.ros2_folder import open_ros2, open_ros2_folder
from orbident.recordings.bags.topic import RawMessage, Storage, Topic

_FILES = {".bag": open_ros1, ".mcap": open_mcap, ".db3": open_ros2}
_REPAIRS = {
    ".bag": "rosbag reindex",
    ".mcap": "mcap recover",
    "": "ros2 bag reindex",
}


@dataclass(frozen=True)
class Bag:
    """What is in a bag."""

    path: Path
    topics: Mapping[str, Topic]
    _storage: Storage
    notes: tuple[str, ...] = ()
    """Warnings."""

    def topic(self, name: str) -> Topic:
        """A topic that has messages.

        Raises:
            InputError: the bag does not have it, or has no message of it.
        """
        if name not in self.topics:
            close = closest(name, self.topics)
            hint = f"did you mean '{close}'? " if close else ""
            raise InputError(
                f"{self.path}: has no topic '{name}'; {hint}it has "
                + listed(self.topics)
            )
        if not self.topics[name].count:
            raise InputError(
                f"{self.path}: topic '{name}' has no messages; take it out of the map, "
                "or record again"
            )
        return self.topics[name]

    def messages(self, names: Collection[str]) -> Iterator[RawMessage]:
        """Every message of these topics, in the order of the file or of its index.

        Raises:
            InputError: the bag is damaged.
        """
        messages = iter(self._storage.messages(names))
        while True:
            # What the libraries raise over damaged bytes is of any kind.
            try:
                message = next(messages)
            except StopIteration:
                return
            except Exception as error:
                raise InputError(_damaged(self.path, error)) from error
            yield message


@contextmanager
def open_bag(path: Path) -> Iterator[Bag]:
    """A ROS 1 bag, a ROS 2 bag (folder or .db3 file), or a bare MCAP file, that exists.

    Raises:
        InputError: it is none, it is damaged, or it has no messages.
    """
    opening = _opening(path)
    with ExitStack() as stack:
        try:
            storage = stack.enter_context(opening)
        except InputError:
            raise
        except PermissionError as error:
            raise InputError(
                f"{path}: cannot be read ({error.strerror or error})"
            ) from error
        except Exception as error:
            raise InputError(_damaged(path, error)) from error
        topics = {topic.name: topic for topic in storage.topics}
        if not any(topic.count for topic in topics.values()):
            raise InputError(f"{path}: holds no messages; record again")
        yield Bag(path, topics, storage, storage.notes)


def _opening(path: Path) -> AbstractContextManager[Storage]:
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
