"""A bag of any kind, open for reading: of ROS 1 or ROS 2, or a bare MCAP file.

It says what its topics are, and how a message's bytes are read.
"""

import struct
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field, replace
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO, cast

from orbident.errors import InputError
from orbident.extras import extra
from orbident.files.names import one_line
from orbident.files.text import unreadable
from orbident.recordings.source import RawMessage, Source

# The one import of the libraries that read bags.
with extra("ros", "reading or writing a bag"):
    from mcap.exceptions import EndOfFile as McapEnd
    from mcap.reader import NonSeekingReader as McapStream
    from mcap.reader import SeekingReader as McapIndex
    from mcap.records import Channel as McapChannel
    from mcap.records import Schema as McapSchema
    from rosbags.interfaces import MessageDefinitionFormat, TopicInfo
    from rosbags.rosbag1 import Reader as Ros1Reader
    from rosbags.rosbag1.reader import Header as Ros1Header
    from rosbags.rosbag1.reader import RecordType as Ros1Record
    from rosbags.rosbag1.reader import read_bytes, read_uint32
    from rosbags.rosbag2 import Reader as Ros2Reader
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore
    from rosbags.typesys.store import Typestore

_MAGIC = b"\x89MCAP0\r\n"
_FOOTER = 2
"""The number of the record that comes last, before the magic once more."""


@dataclass(frozen=True)
class Topic:
    """One topic of a bag."""

    name: str
    type: str
    """Without `/msg/`: `sensor_msgs/Imu`."""
    count: int
    """Messages."""
    encoding: str
    """`ros1` and `cdr` can be read."""
    definition: str = field(repr=False)
    """The message definition that the bag carries; empty where it has none."""

    @property
    def is_defined(self) -> bool:
        """Whether its messages can be decoded."""
        with suppress(InputError):
            self.decoder("")
            return True
        return False

    def decoder(self, place: str) -> Callable[[bytes], Any]:
        """What turns a message's bytes into the message, or None if they are not one.

        The bag's own definition of the type is used, else ROS's.

        Raises:
            InputError: the encoding is none of ROS, or the definition cannot be read.
        """
        name = self.type.replace("/", "/msg/")
        known = {"ros1": Stores.ROS1_NOETIC, "cdr": Stores.ROS2_HUMBLE}
        if self.encoding not in known:
            raise InputError(
                f"{place}: topic '{self.name}' is encoded as {self.encoding!r}; only "
                "ROS messages (ros1, cdr) can be read"
            )
        if self.definition:
            store = get_typestore(Stores.EMPTY)
            try:
                store.register(get_types_from_msg(self.definition, name))
            except Exception as error:
                raise InputError(
                    f"{place}: topic '{self.name}': the definition of {self.type} "
                    f"cannot be read ({one_line(error)})"
                ) from error
            for part, field in _missing(store):
                raise InputError(
                    f"{place}: topic '{self.name}': its {self.type} is not ROS's: "
                    f"{part} has no '{field}' as it has there; convert its messages "
                    "to the standard type"
                )
        else:
            store = get_typestore(known[self.encoding])
            if name not in store.fielddefs:
                raise InputError(
                    f"{place}: topic '{self.name}': the file has no definition of "
                    f"{self.type}; record as MCAP, or by ROS 2 from Jazzy on"
                )
        read = (
            store.deserialize_ros1 if self.encoding == "ros1" else store.deserialize_cdr
        )

        def decoded(data: bytes) -> Any:
            # Bytes that are not of their type raise errors of many kinds.
            with suppress(Exception):
                return read(data, name)
            return None

        return decoded


def _missing(store: Typestore) -> Iterator[tuple[str, str]]:
    """Types of ROS as a bag defines them, and fields that each lacks or has changed.

    A ROS 1 header has all that a ROS 2 header has, and so have the other types.
    """
    standard = get_typestore(Stores.ROS2_HUMBLE).fielddefs
    for name, (_, fields) in store.fielddefs.items():
        _, expected = standard.get(name, ([], []))
        for one in expected:
            if one not in fields:
                yield short_type(name), one[0]


def by_name(topics: Iterable[Topic]) -> dict[str, Topic]:
    """One topic for all of its name."""
    found: dict[str, Topic] = {}
    for each in topics:
        same = found.get(each.name, replace(each, count=0))
        kind = each.type if each.type == same.type else f"{same.type} and {each.type}"
        found[each.name] = replace(each, type=kind, count=same.count + each.count)
    return found


def short_type(name: str) -> str:
    """`sensor_msgs/msg/Imu` as ROS 1 writes it: `sensor_msgs/Imu`."""
    return name.replace("/msg/", "/")


def described(name: str, info: TopicInfo, encoding: str) -> Topic:
    """A topic as the library rosbags describes it."""
    types = sorted({short_type(each.msgtype) for each in info.connections})
    plain = info.msgdef.format == MessageDefinitionFormat.MSG
    text = info.msgdef.data if plain else ""
    return Topic(name, " and ".join(types), info.msgcount, encoding, text)


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
        _topic(each, summary.schemas.get(each.schema_id), counts.get(each.id, 0))
        for each in summary.channels.values()
    )


def _scanned(whole: _Beginning) -> dict[str, Topic]:
    counts: Counter[int] = Counter()
    found: dict[int, tuple[McapChannel, McapSchema | None]] = {}
    for schema, channel, _ in _stream(whole):
        counts[channel.id] += 1
        found[channel.id] = channel, schema
    return by_name(_topic(*each, counts[number]) for number, each in found.items())


def _topic(channel: McapChannel, schema: McapSchema | None, count: int) -> Topic:
    kind, definition = "no schema", ""
    if schema is not None:
        kind = short_type(schema.name)
        text = schema.encoding in {"ros1msg", "ros2msg"}
        definition = schema.data.decode() if text else ""
    return Topic(channel.topic, kind, count, channel.message_encoding, definition)


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
_REPAIRS = {".bag": "rosbag reindex", ".mcap": "mcap recover", "": "ros2 bag reindex"}


@contextmanager
def open_bag(path: Path) -> Iterator[Source]:
    """A ROS 1 bag, a ROS 2 bag (folder or .db3 file), or a bare MCAP file, that exists.

    Raises:
        InputError: it is none, it is damaged, or it has no messages.
    """
    if not (path.is_dir() or path.stat().st_size):
        raise InputError(f"{path}: is empty; record again")
    opened = open_ros2_folder if path.is_dir() else _FILES[path.suffix.lower()]
    with ExitStack() as stack:
        try:
            source = stack.enter_context(opened(path))
        except InputError:
            raise
        except PermissionError as error:
            raise unreadable(path, error) from error
        except Exception as error:
            raise InputError(_damaged(path, error)) from error
        if not any(topic.count for topic in source.topics.values()):
            raise InputError(f"{path}: holds no messages; record again")

        def messages(names: Collection[str]) -> Iterator[RawMessage]:
            # What the libraries raise over damaged bytes is of any kind.
            try:
                yield from source.messages(names)
            except Exception as error:
                raise InputError(_damaged(path, error)) from error

        yield replace(source, messages=messages)


def _damaged(path: Path, error: Exception) -> str:
    repair = _REPAIRS.get(path.suffix.lower(), _REPAIRS[""])
    return (
        f"{path}: is damaged or no bag of this kind ({one_line(error)}); "
        f"copy it again, or repair it with '{repair}'"
    )
