"""ROS 2 bags: folders, and single .db3 files."""

from collections.abc import Collection, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from orbident.errors import InputError
from orbident.recordings.bags.libraries import Ros2Reader
from orbident.recordings.bags.mcap_file import open_mcap
from orbident.recordings.bags.topic import by_name, described
from orbident.recordings.source import RawMessage, Source


@contextmanager
def open_ros2(path: Path) -> Iterator[Source]:
    """A folder with metadata.yaml, or one `.db3` file."""
    with Ros2Reader(path) as reader:

        def messages(names: Collection[str]) -> Iterator[RawMessage]:
            wanted = [each for each in reader.connections if each.topic in names]
            for connection, received, data in reader.messages(wanted):
                # A cell of SQLite holds any type, whatever its column is declared as.
                if not (isinstance(received, int) and isinstance(data, bytes)):
                    raise TypeError(f"a message of '{connection.topic}' is none")
                yield RawMessage(connection.topic, received, data)

        topics = by_name(described(*each, "cdr") for each in reader.topics.items())
        yield Source(path, topics, messages)


@contextmanager
def open_ros2_folder(path: Path) -> Iterator[Source]:
    """A folder with SQLite or MCAP files.

    ROS writes metadata.yaml when a recording is ended. Where that did not happen, the
    files are read one after the other.

    Raises:
        InputError: It has no such file.
    """
    if (path / "metadata.yaml").is_file():
        with open_ros2(path) as source:
            yield source
        return
    readers = {".mcap": open_mcap, ".db3": open_ros2}
    files = [
        each
        for each in path.iterdir()
        if each.suffix in readers and each.is_file() and each.stat().st_size
    ]
    if not files:
        raise InputError(
            f"{path}: is a folder without metadata.yaml and without .mcap or .db3 "
            "files; give a file, or the folder of a ROS 2 bag"
        )
    with ExitStack() as stack:
        # They are numbered: flight_9 comes before flight_10.
        parts = [
            stack.enter_context(readers[each.suffix](each))
            for each in sorted(files, key=lambda each: (len(each.name), each.name))
        ]

        def messages(names: Collection[str]) -> Iterator[RawMessage]:
            for part in parts:
                yield from part.messages(names)

        note = (
            f"{path}: has no metadata.yaml, as when a recording is not ended; its "
            "files are read all the same"
        )
        yield Source(
            path,
            by_name(topic for part in parts for topic in part.topics.values()),
            messages,
            (note, *(note for part in parts for note in part.notes)),
        )
