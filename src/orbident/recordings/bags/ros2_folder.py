"""ROS 2 bags: folders with metadata.yaml, and single .db3 files."""

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path

from orbident.recordings.bags.libraries import Ros2Reader
from orbident.recordings.bags.storage import Storage
from orbident.recordings.bags.topic import RawMessage, described


@contextmanager
def open_ros2(path: Path) -> Iterator[Storage]:
    """A folder with SQLite or MCAP files, or one `.db3` file."""
    with Ros2Reader(path) as reader:

        def messages(names: Collection[str]) -> Iterator[RawMessage]:
            wanted = [each for each in reader.connections if each.topic in names]
            for connection, received, data in reader.messages(wanted):
                yield RawMessage(connection.topic, received, data)

        topics = [described(name, info, "cdr") for name, info in reader.topics.items()]
        yield Storage(topics, messages)
