"""A file of another tool into a recording, and what became of every message."""

import os
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool

from orbident.errors import InputError
from orbident.files.names import listed
from orbident.recordings.logs.group import Group
from orbident.recordings.no_measurements import (
    no_measurements,
    reasons_in_words,
    sensor_groups,
)
from orbident.recordings.source import Source
from orbident.recordings.tables import check_writable, write_blocks
from orbident.recordings.topics.fields import missing_of
from orbident.recordings.topics.presets import preset_path, presets
from orbident.recordings.topics.survey import open_source
from orbident.recordings.topics.timing import Timed, common_rows, timed
from orbident.recordings.topics.topic_map import load_topic_map
from orbident.recordings.topics.track import Track

_NO_STAMP = "no header stamp is set, so the time is when it was recorded"


@dataclass(frozen=True)
class TopicReport:
    """One entry of the map: all its samples are used or rejected, and counted."""

    topic: str
    type: str
    columns: tuple[str, ...]
    clock: str | None
    """The map's name for the clock."""
    time: str
    """Which time it is: "header", "receive", or "stamp" of a table."""
    messages: int
    used: int
    """Samples in the recording."""
    rejected: dict[str, int]
    """Samples, and messages that could not be decoded, by reason."""
    duplicate_differs: int
    """How many of the rejected duplicates held other values."""
    incomplete: int
    not_finite: int
    emptied: dict[str, dict[str, int]]
    """Samples that are no measurement and were left empty, by sensor and reason."""
    out_of_order: int
    rate: float | None
    """Hz: one over the median interval; None for a single sample."""
    start: float
    """s, on the recording's `t`."""
    end: float
    note: str = ""
    """What a person should know of the clock."""

    def sentences(self) -> list[str]:
        """What was odd, in words; nothing where nothing was."""
        found = [
            (
                self.rejected["duplicate"],
                f"repeated a stamp, rejected ({self.duplicate_differs} differ)",
            ),
            (self.rejected["without_stamp"], "had a zero stamp, rejected"),
            (self.rejected["undecodable"], "could not be decoded, rejected"),
            (self.out_of_order, "came late, sorted"),
            (self.incomplete, "lacked a name of the map"),
            (self.not_finite, "held NaN or no number, left empty"),
        ]
        said = [f"{count} {what}" for count, what in found if count]
        for sensor, reasons in self.emptied.items():
            words = reasons_in_words(reasons)
            said += [f"{sensor}: {each}, left empty" for each in words]
        return [f"{self.topic}: {each}" for each in (*said, self.note) if each]


@dataclass(frozen=True, repr=False)
class ConversionReport:
    """What `convert_file` did: the recording, and what became of every message."""

    file: str
    """The file that was read."""
    recording: str
    """The recording that was written."""
    samples: int
    """Rows of the recording."""
    start_ns: int
    """Absolute time of `t = 0`, ns."""
    duration: float
    """Time of the last row, s."""
    topics: tuple[TopicReport, ...]
    """What became of the messages of every entry of the map."""
    warnings: tuple[str, ...]
    """What was odd, in sentences."""

    def __repr__(self) -> str:
        """How long the recording is and what it was made from."""
        made = f"{self.file}: {self.samples} samples over {self.duration:.6g} s"
        topics = ", ".join(f"{topic.topic} ({topic.used})" for topic in self.topics)
        return "\n".join([f"{made} from {topics}", *self.warnings])

    def to_json(self) -> dict[str, Any]:
        """As `orbident convert --json` writes it."""
        return {
            "schema": "orbident/conversion/1",
            **vars(self),
            "topics": [{**vars(x), "columns": list(x.columns)} for x in self.topics],
            "warnings": list(self.warnings),
        }


def topic_report(
    timed: Timed, start_ns: int, emptied: dict[str, dict[str, int]]
) -> TopicReport:
    """The counts of one entry."""
    track, entry = timed.track, timed.track.entry
    stamps = timed.stamps
    interval = float(np.median(np.diff(stamps))) if stamps.size > 1 else None
    return TopicReport(
        topic=entry.topic,
        type=entry.type,
        columns=entry.columns,
        clock=entry.clock,
        time=timed.clock,
        messages=track.messages,
        used=stamps.size,
        rejected=timed.rejected,
        duplicate_differs=timed.duplicate_differs,
        incomplete=track.incomplete,
        not_finite=track.not_finite,
        emptied=emptied,
        out_of_order=timed.out_of_order,
        rate=None if interval is None else 1e9 / interval,
        start=float(stamps[0] - start_ns) / 1e9,
        end=float(stamps[-1] - start_ns) / 1e9,
        note=timed.note or ("" if timed.clock in {entry.time, "stamp"} else _NO_STAMP),
    )


def apart(topics: tuple[TopicReport, ...]) -> tuple[str, ...]:
    """A warning where two topics have no time in common."""
    last = max(topics, key=lambda topic: topic.start)
    first = min(topics, key=lambda topic: topic.end)
    if last.start <= first.end:
        return ()
    return (
        f"'{first.topic}' ends {last.start - first.end:.6g} s before '{last.topic}' "
        "begins: their clocks differ, or they were not recorded together; "
        "'time: receive' takes the recorder's clock",
    )


_LATE = 1.0
"""s: no message takes so long from its sender to the recorder."""


def clocks_apart(used: Sequence[Timed]) -> tuple[str, ...]:
    """A warning where senders' clocks differ by more than messages take."""
    heard = [each for each in used if each.clock == each.track.entry.sender_time]
    if not heard:
        return ()
    first, last = (pick(heard, key=lambda each: each.ahead) for pick in (min, max))
    if (behind := last.ahead - first.ahead) < _LATE:
        return ()
    name, other = (each.track.entry.topic for each in (first, last))
    return (
        f"the clock of '{name}' is {behind:.3f} s behind that of '{other}', by when "
        f"the messages were recorded: give '{name}' 'offset: {behind:.3f}', added to "
        "one that it has",
    )


_LOOKED_AT = 65_536
"""Samples that are looked at together: of what is held, some are kept where they meet.
"""


def emptied(
    used: Timed,
) -> tuple[Bool[np.ndarray, "used columns"], dict[str, dict[str, int]]]:
    """What is left empty of the samples of an entry, in the order of their times.

    How many samples that are is said by sensor and reason.
    """
    names = used.track.entry.columns
    groups = [
        (sensor, [names.index(name) for name in columns])
        for sensor, columns in sensor_groups(names).items()
    ]
    empty = np.zeros((used.order.size, len(names)), dtype=bool)
    reasons = defaultdict[str, Counter[str]](Counter)
    if used.track.zeros:
        reasons["attitude"]["quaternion of zeros"] = used.track.zeros
    for start in range(0, used.order.size, _LOOKED_AT):
        rows = slice(start, start + _LOOKED_AT)
        block = used.track.rows.gather(used.order[rows])
        for sensor, columns in groups:
            for reason, mask in no_measurements(sensor, block[:, columns]).items():
                empty[start + np.flatnonzero(mask)[:, None], columns] = True
                reasons[sensor][reason] += int(mask.sum())
    return empty, {sensor: dict(why) for sensor, why in reasons.items()}


_BLOCK_ROWS = 32_768
"""What is written at once: a row group of Parquet."""
_SAID_EVERY = 4096


def convert_file(
    file: str | os.PathLike[str],
    topic_map: str | os.PathLike[str],
    recording: str | os.PathLike[str],
    progress: Callable[[float], None] | None = None,
) -> ConversionReport:
    """Write the mapped topics of a file as a recording, .parquet or .csv.

    Rows are the union of all stamps; `t` is 0 at the first. The values of a bag,
    however large, wait in temporary files beside the recording; only their times are
    held in memory.

    Args:
        file: a ROS bag, an MCAP file, or one of MATLAB, HDF5, PX4's ULog, NumPy,
            Parquet or CSV.
        topic_map: what each topic feeds; a file, or the name of a preset. Of a preset,
            topics that the file does not have are left out, with a warning.
        recording: where to; replaced if it exists.
        progress: called with the fraction done.

    Returns:
        What became of every message.

    Raises:
        InputError: The file, the map or the place cannot be used, or they do not fit
            together. One line: file, place, what was found, what to do.
    """
    out = Path(recording)
    check_writable(out)
    is_preset = str(topic_map) in presets()
    path = preset_path(str(topic_map)) if is_preset else Path(topic_map)
    mapped = f"preset '{topic_map}'" if is_preset else str(path)
    entries = load_topic_map(path, mapped)
    said = progress or (lambda fraction: None)
    with open_source(Path(file)) as source:
        missing = [
            missing_of(entry, source.topics) if is_preset else None for entry in entries
        ]
        if all(missing):
            raise InputError(
                f"{source.path}: has none of the topics of {mapped}, only "
                f"{listed(source.topics)}; write a map: 'orbident topics' proposes one"
            )
        tracks = [
            Track(entry, out)
            for entry, lacked in zip(entries, missing, strict=True)
            if not lacked
        ]
        try:
            _collect(source, tracks, mapped, said)
            used = [timed(track, str(source.path)) for track in tracks]
            report = _written(used, str(file), out, said)
        finally:
            for track in tracks:
                track.rows.close()
    left_out = [
        f"{mapped}: the file has no {kind} {listed(dict.fromkeys(names))}: left out"
        for kind in ("topic", "field")
        if (names := [name for what, name in filter(None, missing) if what == kind])
    ]
    return replace(report, warnings=(*source.notes, *left_out, *report.warnings))


def _collect(
    source: Source, tracks: Sequence[Track], place: str, said: Callable[[float], None]
) -> None:
    """All samples to the tracks of their topics; three quarters of the work."""
    fed: dict[str, list[Track]] = defaultdict(list)
    for track in tracks:
        entry = track.entry
        found = source.topic(entry.topic).type
        if found != entry.type:
            raise InputError(
                f"{place}: topic {entry.topic}: type: found {entry.type}, "
                f"but it is {found} in {source.path}; correct it"
            )
        fed[entry.topic].append(track)
    topics = {name: source.topics[name] for name in fed}
    decoders = {n: topic.decoder(str(source.path)) for n, topic in topics.items()}
    total = sum(topic.count for topic in topics.values())
    done, told = 0, 0
    for topic, received, data in source.messages(fed):
        message = decoders[topic](data)
        done += message.count if isinstance(message, Group) else 1
        for track in fed[topic]:
            track.add(received, message)
        if done >= told:
            said(0.75 * min(done / total, 1.0))
            told = done + _SAID_EVERY


def _written(
    used: Sequence[Timed], file: str, out: Path, said: Callable[[float], None]
) -> ConversionReport:
    rows, indices = common_rows([each.stamps for each in used])
    if rows.size < 2:
        raise InputError(f"{file}: has a single sample; at least 2 are needed")
    names = ["t", *(name for each in used for name in each.track.entry.columns)]
    empty, reasons = zip(*map(emptied, used), strict=True)
    write_blocks(out, names, _blocks(used, empty, rows, indices, said))
    start_ns = int(rows[0])
    topics = tuple(
        topic_report(each, start_ns, why)
        for each, why in zip(used, reasons, strict=True)
    )
    return ConversionReport(
        file=file,
        recording=str(out),
        samples=rows.size,
        start_ns=start_ns,
        duration=float(rows[-1] - rows[0]) / 1e9,
        topics=topics,
        warnings=(*apart(topics), *clocks_apart(used)),
    )


def _blocks(
    used: Sequence[Timed],
    empty: Sequence[np.ndarray],
    rows: np.ndarray,
    indices: Sequence[np.ndarray],
    said: Callable[[float], None],
) -> Iterator[np.ndarray]:
    edges = np.cumsum([1, *(len(each.track.entry.columns) for each in used)])
    for start in range(0, rows.size, _BLOCK_ROWS):
        stop = min(start + _BLOCK_ROWS, rows.size)
        block = np.full((stop - start, int(edges[-1])), np.nan)
        block[:, 0] = (rows[start:stop] - rows[0]) / 1e9
        for k, each in enumerate(used):
            low, high = np.searchsorted(indices[k], [start, stop])
            values = each.track.rows.gather(each.order[low:high])
            values = np.where(empty[k][low:high], np.nan, values)
            block[indices[k][low:high] - start, edges[k] : edges[k + 1]] = values
        yield block
        said(0.75 + 0.25 * stop / rows.size)
