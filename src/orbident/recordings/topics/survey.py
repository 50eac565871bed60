"""What is in a file of any kind: topics, their rates, and an example of each."""

import os
from collections import defaultdict
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, field, replace
from itertools import islice
from operator import itemgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from orbident.errors import InputError
from orbident.files.text import refuse_pipe
from orbident.recordings.logs.group import Group, listed_fields
from orbident.recordings.logs.log import KINDS, is_log, open_log
from orbident.recordings.source import Source
from orbident.recordings.topics.any_message import Message, numbers_of
from orbident.recordings.topics.entry import Entry, header_stamp
from orbident.recordings.topics.messages import MESSAGE_TYPES
from orbident.recordings.topics.targets import TIMES

if TYPE_CHECKING:
    from orbident.recordings.bag import Topic

_BAGS = (".bag", ".mcap", ".db3")


def open_source(path: Path) -> AbstractContextManager[Source]:
    """A bag or a file of tables; the suffix says which.

    Raises:
        InputError: There is none, its suffix is unknown, it is damaged or empty, or
            the library that reads it is not installed.
    """
    if not path.exists():
        raise InputError(f"{path}: does not exist; check the path")
    refuse_pipe(path, "the recording")
    if is_log(path):
        return open_log(path)
    if path.suffix.lower() not in _BAGS and not path.is_dir():
        known = [*_BAGS, *(suffix for kind in KINDS for suffix in kind.suffixes)]
        raise InputError(
            f"{path}: what can be read is a file whose name ends in one of "
            f"{', '.join(known)}, or the folder of a ROS 2 bag or of NASA's 42"
        )
    # Late, because its libraries are an extra.
    from orbident.recordings.bag import open_bag

    return open_bag(path)


LISTED = 100
"""Fields of a table that are listed, with their ranges."""
_EXAMPLES = 200
"""Messages of a topic that are decoded, the first and as many spread over the rest."""
_FEWEST = 9
"""Headers that tell a clock: three in each third, so that one that is off is not heard.
"""
_SAID_EVERY = 4096


@dataclass(frozen=True)
class Surveyed:
    """A topic of a file that `survey_file` looked through."""

    topic: "Topic | Group"
    """The topic, with its name, type and number of messages."""
    rate: float | None
    """Hz, on the recorder's clock; None for fewer than two messages, and for a table
    whose time has no unit."""
    labels: tuple[str, ...] = ()
    """Names of joints, of transforms, or of fields, in the order of the file."""
    example: Any = field(default=None, repr=False)
    """The first message of the topic that can be decoded."""
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    """Least and largest value of each number of its messages, or of each field of a
    table, as they are there."""
    offset: float | None = None
    """s, header minus receive, the median: how far the sender's clock is ahead."""
    drift: float | None = None
    """How fast the time between header and receipt grows, s/s."""
    notes: tuple[str, ...] = ()
    """What of the whole file is missing."""


def survey_file(
    file: str | os.PathLike[str], progress: Callable[[float], None] | None = None
) -> tuple[Surveyed, ...]:
    """Lists a file's topics, by name; a bag is read once, whole.

    Args:
        file: a ROS bag, an MCAP file, or one of MATLAB, HDF5, PX4's ULog, NumPy,
            Parquet or CSV.
        progress: called with the fraction done.

    Raises:
        InputError: It is of no kind that can be read, damaged or empty.
    """
    with open_source(Path(file)) as opened:
        looked = _looked_through(opened, progress or (lambda fraction: None))
        return tuple(
            replace(
                _surveyed_table(topic)
                if isinstance(topic, Group)
                else _surveyed(topic, looked[name]),
                notes=opened.notes,
            )
            for name, topic in sorted(opened.topics.items())
        )


def _surveyed_table(group: Group) -> Surveyed:
    time = group.time
    unit = TIMES.get(group.unit(time) or "s") if time else None
    rate = None
    if time and unit and group.count > 1:
        times = group.column(time)
        # Not as float64, in which dates in ns are not exact.
        exact = times.astype(np.int64) if times.dtype.kind == "u" else times
        interval = float(np.median(np.diff(exact)))
        # What the times' own rounding leaves of it.
        rate = float(f"{1e9 / (interval * unit):.6g}") if interval > 0 else None
    ranges = {
        name: extent
        for name in islice(group.usable, LISTED)
        if name != time and (extent := group.extent(name))
    }
    return Surveyed(group, rate, tuple(listed_fields(group)), ranges=ranges)


@dataclass
class _Look:
    """What has been seen of a topic so far."""

    count: int = 0
    first: int = 0
    last: int = 0
    labels: dict[str, None] = field(default_factory=dict)
    example: Any = None
    ranges: dict[str, tuple[float, float]] = field(default_factory=dict)
    times: list[tuple[int, int]] = field(default_factory=list)
    """ns, of the header and of recording."""

    def take(self, received: int, message: Any, kind: type[Entry]) -> None:
        """Looks at one message."""
        self.labels.update(dict.fromkeys(kind.labels(message)))
        self.example = self.example or message
        for path, x in numbers_of(message).items():
            low, high = self.ranges.get(path, (x, x))
            # Without the NaN that either may be.
            self.ranges[path] = float(np.fmin(low, x)), float(np.fmax(high, x))
        inner = getattr(message, "transforms", None)
        of = inner[0] if isinstance(inner, list) and inner else message
        if stamp := header_stamp(getattr(of, "header", None)):
            self.times.append((stamp, received))

    def clock(self) -> tuple[float | None, float | None]:
        """Header minus receive, s, and its drift: a line through medians of thirds."""
        if len(self.times) < _FEWEST:
            return None, None
        sent, received = np.array(sorted(self.times, key=itemgetter(1))).T
        ahead, t = (sent - received) / 1e9, (received - received[0]) / 1e9
        third = len(t) // 3
        rise, run = (
            float(np.median(x[-third:]) - np.median(x[:third])) for x in (ahead, t)
        )
        return float(np.median(ahead)), rise / run if run > 0 else None


def _looked_through(source: Source, said: Callable[[float], None]) -> dict[str, _Look]:
    streams = {n: t for n, t in source.topics.items() if not isinstance(t, Group)}
    decoders = {
        name: topic.decoder(str(source.path))
        for name, topic in streams.items()
        if topic.encoding in {"ros1", "cdr"}
        and (topic.type in MESSAGE_TYPES or topic.is_defined)
    }
    spread = {n: max(topic.count // _EXAMPLES, 1) for n, topic in streams.items()}
    total = sum(topic.count for topic in streams.values())
    looks = defaultdict(_Look)
    for number, (name, received, data) in enumerate(source.messages(streams)):
        look = looks[name]
        look.first = min(look.first, received) if look.count else received
        look.last = max(look.last, received)
        if look.count < _EXAMPLES or not look.count % spread[name]:
            message = decoders[name](data) if name in decoders else None
            if message is not None:
                kind = MESSAGE_TYPES.get(streams[name].type, Message)
                look.take(received, message, kind)
        look.count += 1
        if number % _SAID_EVERY == 0:
            said(min(number / total, 1.0))
    return looks


def _surveyed(topic: "Topic", look: _Look) -> Surveyed:
    span = look.last - look.first
    rate = (look.count - 1) * 1e9 / span if span > 0 else None
    labels = tuple(look.labels)
    return Surveyed(topic, rate, labels, look.example, look.ranges, *look.clock())
