"""Bare MCAP files, of ROS 1 or ROS 2."""

import struct
from collections import Counter
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO, cast

from orbident.recordings.bags.libraries import (
    McapChannel,
    McapEnd,
    McapIndex,
    McapSchema,
    McapStream,
)
from orbident.recordings.bags.topic import (
    Topic,
    by_name,
    short_type,
)
from orbident.recordings.source import RawMessage, Source

_MAGIC = b"\x89MCAP0\r\n"
_FOOTER = 2
"""The number of the record that comes last, before the magic once more."""


@contextmanager
def open_mcap(path: Path) -> Iterator[Source]:
    """A `.mcap` file; messages come in the order of the file.

    One that was cut off, as when power is lost, is read up to there.
    """
    with path.open("rb") as file:
        size = end = path.stat().st_size
        try:
            topics = _indexed(file)
        except Exception:
            end = _whole_until(file, size)
            if end == size:
                raise
            topics = {}
        whole = _Beginning(file, end)
        topics = topics or _scanned(whole)
        if end < size and not topics:
            raise ValueError("it is cut off before its first whole message")

        def messages(names: Collection[str]) -> Iterator[RawMessage]:
            for _, channel, message in _stream(whole, names):
                yield RawMessage(channel.topic, message.log_time, message.data)

        yield Source(path, topics, messages, (_cut_off(path),) if end < size else ())


class _Beginning:
    """A file up to a place."""

    def __init__(self, file: BinaryIO, end: int) -> None:
        self.file, self.end = file, end

    def read(self, count: int) -> bytes:
        return self.file.read(min(count, self.end - self.file.tell()))


def _whole_until(file: BinaryIO, size: int) -> int:
    """Where the first record begins that is not whole; the size if nothing is cut."""
    file.seek(0)
    at = len(_MAGIC) if file.read(len(_MAGIC)) == _MAGIC else size
    while at < size:
        file.seek(at)
        # Each says its kind and its length; zeros are what was never written.
        kind, length = struct.unpack("<BQ", file.read(9).ljust(9, b"\0"))
        end = at + 9 + length
        if not kind or end > size:
            break
        if kind == _FOOTER:
            return size if end + len(_MAGIC) <= size else at
        at = end
    return at


def _cut_off(path: Path) -> str:
    return (
        f"{path}: is cut off: what is before is used; copy it again, unless the "
        "recorder lost power"
    )


def _stream(whole: _Beginning, names: Collection[str] | None = None) -> Iterator:
    # The library's seeking reader reads every chunk before it gives a message, or
    # keeps a heap of them.
    whole.file.seek(0)
    stream = McapStream(cast("BinaryIO", whole), validate_crcs=True)
    try:
        yield from stream.iter_messages(names, log_time_order=False)
    except McapEnd:
        # Of what was cut off; else the footer comes before.
        if whole.file.tell() != whole.end:
            raise


def _indexed(file: BinaryIO) -> dict[str, Topic]:
    """The topics in the summary that ends the file; none where it has no summary."""
    summary = McapIndex(file).get_summary()
    if summary is None or summary.statistics is None:
        return {}
    counts = summary.statistics.channel_message_counts
    return by_name(
        _topic(
            channel,
            summary.schemas.get(channel.schema_id),
            counts.get(channel.id, 0),
        )
        for channel in summary.channels.values()
    )


def _scanned(whole: _Beginning) -> dict[str, Topic]:
    counts: Counter[int] = Counter()
    found: dict[int, tuple[McapChannel, McapSchema | None]] = {}
    for schema, channel, _ in _stream(whole):
        counts[channel.id] += 1
        found[channel.id] = channel, schema
    return by_name(_topic(*each, counts[number]) for number, each in found.items())


def _topic(channel: McapChannel, schema: McapSchema | None, count: int) -> Topic:
    kind, definition = _schema(schema)
    return Topic(channel.topic, kind, count, channel.message_encoding, definition)


def _schema(schema: McapSchema | None) -> tuple[str, str]:
    if schema is None:
        return "no schema", ""
    text = schema.encoding in {"ros1msg", "ros2msg"}
    return short_type(schema.name), schema.data.decode() if text else ""
