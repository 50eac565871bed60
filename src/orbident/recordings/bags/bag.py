"""A bag of any kind, open for reading: of ROS 1 or ROS 2, or a bare MCAP file."""

import struct
from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import BinaryIO, cast

from orbident.errors import InputError
from orbident.files.names import one_line
from orbident.recordings.bags.libraries import (
    McapChannel,
    McapEnd,
    McapIndex,
    McapSchema,
    McapStream,
    Ros1Header,
    Ros1Reader,
    Ros1Record,
    Ros2Reader,
    read_bytes,
    read_uint32,
)
from orbident.recordings.bags.topic import Topic, by_name, described, short_type
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

        note = (
            f"{path}: is cut off: what is before is used; copy it again, unless the "
            "recorder lost power"
        )
        yield Source(path, topics, messages, (note,) if end < size else ())


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


class _WithoutIndex(Ros1Reader):
    """The library's index takes 150 bytes a message, which here nobody needs."""

    def read_index_data(self, pos: int, indexes: object) -> None:
        """Chunks are read whole."""


@contextmanager
def open_ros1(path: Path) -> Iterator[Source]:
    """A `.bag` file; messages come in the order of the file."""
    with _WithoutIndex(path) as reader:
        topics = by_name(described(*each, "ros1") for each in reader.topics.items())
        yield Source(path, topics, lambda names: _messages(reader, names))


def _messages(reader: Ros1Reader, names: Collection[str]) -> Iterator[RawMessage]:
    topics = {each.id: each.topic for each in reader.connections if each.topic in names}
    for info in reader.chunk_infos:
        if topics.keys().isdisjoint(info.connection_counts) or reader.bio is None:
            continue
        chunk = reader.chunks[info.pos]
        reader.bio.seek(chunk.datapos)
        data = chunk.decompressor(read_bytes(reader.bio, chunk.datasize))
        yield from _in_chunk(data, topics)


def _in_chunk(data: bytes, topics: Mapping[int, str]) -> Iterator[RawMessage]:
    stream = BytesIO(data)
    while stream.tell() < len(data):
        header = Ros1Header.read(stream)
        content = read_bytes(stream, read_uint32(stream))
        if header.get_uint8("op") != Ros1Record.MSGDATA:
            continue
        topic = topics.get(header.get_uint32("conn"))
        if topic is not None:
            yield RawMessage(topic, header.get_time("time"), content)


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

        for each in reader.connections:
            if not (isinstance(each.topic, str) and isinstance(each.msgtype, str)):
                raise TypeError(f"the name or the type of topic {each.id} is no text")
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
