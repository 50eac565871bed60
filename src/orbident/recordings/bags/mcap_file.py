"""Bare MCAP files, of ROS 1 or ROS 2."""

from collections import Counter
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from orbident.recordings.bags.libraries import McapIndex, McapSchema, McapStream
from orbident.recordings.bags.storage import Storage
from orbident.recordings.bags.topic import RawMessage, Topic, short_type


@contextmanager
def open_mcap(path: Path) -> Iterator[Storage]:
    """A `.mcap` file; messages come in the order of the file."""
    with path.open("rb") as file:

        def messages(names: Collection[str]) -> Iterator[RawMessage]:
            for _, channel, message in _stream(file, names):
                yield RawMessage(channel.topic, message.log_time, message.data)

        yield Storage(_indexed(file) or _scanned(file), messages)


def _stream(file: BinaryIO, names: Collection[str] | None = None) -> Iterator:
    # The library's seeking reader reads every chunk before it gives a message, or
    # keeps a heap of them.
    file.seek(0)
    stream = McapStream(file, validate_crcs=True)
    return stream.iter_messages(names, log_time_order=False)


def _indexed(file: BinaryIO) -> list[Topic]:
    """The topics in the summary that ends the file; none where it has no summary."""
    summary = McapIndex(file).get_summary()
    if summary is None or summary.statistics is None:
        return []
    counts = summary.statistics.channel_message_counts
    return _topics(
        (
            channel.topic,
            channel.message_encoding,
            summary.schemas.get(channel.schema_id),
            counts.get(channel.id, 0),
        )
        for channel in summary.channels.values()
    )


def _scanned(file: BinaryIO) -> list[Topic]:
    counts, found = Counter(), {}
    for schema, channel, _ in _stream(file):
        counts[channel.id] += 1
        found[channel.id] = channel.topic, channel.message_encoding, schema
    return _topics((*each, counts[number]) for number, each in found.items())


def _topics(
    channels: Iterator[tuple[str, str, McapSchema | None, int]],
) -> list[Topic]:
    """One topic for all channels of its name."""
    topics = {}
    for name, encoding, schema, count in channels:
        same = topics.get(name)
        before = same.count if same else 0
        kind, definition = _schema(schema)
        if same and kind != same.type:
            kind = f"{same.type} and {kind}"
        topics[name] = Topic(name, kind, before + count, encoding, definition)
    return list(topics.values())


def _schema(schema: McapSchema | None) -> tuple[str, str]:
    if schema is None:
        return "no schema", ""
    text = schema.encoding in {"ros1msg", "ros2msg"}
    return short_type(schema.name), schema.data.decode() if text else ""
