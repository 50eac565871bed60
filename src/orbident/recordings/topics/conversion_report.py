"""What became of every message of a file."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from orbident.recordings.no_measurements import reasons_in_words
from orbident.recordings.topics.timing import Timed

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
        differ = self.duplicate_differs
        found = [
            (
                self.rejected["duplicate"],
                f"repeated a stamp, rejected ({differ} differ)",
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
            "file": self.file,
            "recording": self.recording,
            "samples": self.samples,
            "start_ns": self.start_ns,
            "duration": self.duration,
            "topics": [_plain(topic) for topic in self.topics],
            "warnings": list(self.warnings),
        }


def _plain(topic: TopicReport) -> dict[str, Any]:
    return {**vars(topic), "columns": list(topic.columns)}


def topic_report(
    timed: Timed, start_ns: int, emptied: dict[str, dict[str, int]]
) -> TopicReport:
    """The counts of one entry."""
    values, entry = timed.values, timed.values.entry
    stamps = timed.stamps
    interval = float(np.median(np.diff(stamps))) if stamps.size > 1 else None
    return TopicReport(
        topic=entry.topic,
        type=entry.type,
        columns=entry.columns,
        clock=entry.clock,
        time=timed.clock,
        messages=values.messages,
        used=stamps.size,
        rejected={
            "duplicate": timed.duplicate,
            "without_stamp": timed.without_stamp,
            "undecodable": values.undecodable,
        },
        duplicate_differs=timed.duplicate_differs,
        incomplete=values.incomplete,
        not_finite=values.not_finite,
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
