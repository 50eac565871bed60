"""ROS 1 bags, read chunk by chunk."""

from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path

from orbident.recordings.bags.libraries import (
    Ros1Header,
    Ros1Reader,
    Ros1Record,
    read_bytes,
    read_uint32,
)
from orbident.recordings.bags.topic import by_name, described
from orbident.recordings.source import RawMessage, Source


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
