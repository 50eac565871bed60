"""Writing MCAP files of ROS 2 messages, which hold their own definitions."""

from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from orbident.files.replacing import replacing
from orbident.recordings.bags.libraries import McapWriter, Stores, get_typestore

ROS2 = get_typestore(Stores.ROS2_HUMBLE)


def message(name: str, *fields: Any) -> Any:
    """A message of ROS 2.

    Args:
        name: its type, `sensor_msgs/Imu`.
        fields: of the message, in the order of its definition.
    """
    return ROS2.types[name.replace("/", "/msg/")](*fields)


class MessageLog:
    """An MCAP file that is being written."""

    def __init__(self, writer: McapWriter) -> None:
        self._writer = writer
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        self._counts: Counter[str] = Counter()

    @property
    def counts(self) -> Mapping[str, int]:
        """Messages so far, by topic."""
        return dict(self._counts)

    def write(self, topic: str, written: Any, time: int) -> None:
        """Add a message.

        Args:
            topic: all its messages have one type.
            written: as `message` makes it.
            time: when it was measured, ns, not negative.
        """
        kind = written.__msgtype__
        if topic not in self._channels:
            schema = self._schemas.get(kind) or self._registered(kind)
            self._schemas[kind] = schema
            self._channels[topic] = self._writer.register_channel(topic, "cdr", schema)
        data = bytes(ROS2.serialize_cdr(written, kind))
        self._writer.add_message(self._channels[topic], time, data, time)
        self._counts[topic] += 1

    def _registered(self, kind: str) -> int:
        text, _ = ROS2.generate_msgdef(kind, ros_version=2)
        return self._writer.register_schema(kind, "ros2msg", text.encode())


@contextmanager
def writing_mcap(path: Path) -> Iterator[MessageLog]:
    """An MCAP file that is there once the block ends; an existing one is replaced.

    Raises:
        InputError: it cannot be written there.
    """
    with replacing(path) as target, target.open("wb") as file:
        writer = McapWriter(file)
        writer.start(profile="ros2", library="orbident")
        yield MessageLog(writer)
        writer.finish()
