"""A file of another tool into a recording."""

import dataclasses
import os
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float

from orbident.errors import InputError
from orbident.files.names import listed
from orbident.recordings.logs.group import Group
from orbident.recordings.no_measurements import no_measurements, sensor_groups
from orbident.recordings.source import Source
from orbident.recordings.table_writer import write_blocks
from orbident.recordings.tables import check_writable
from orbident.recordings.topics.conversion_report import (
    ConversionReport,
    apart,
    topic_report,
)
from orbident.recordings.topics.fields import missing_of
from orbident.recordings.topics.presets import preset_path, presets
from orbident.recordings.topics.survey import open_source
from orbident.recordings.topics.timing import Timed, check_times, common_rows, timed
from orbident.recordings.topics.topic_map import load_topic_map
from orbident.recordings.topics.track import Track

_LOOKED_AT = 65_536
"""Samples that are looked at together: of what is held, some are kept where they meet.
"""


@dataclass(frozen=True, eq=False)
class Emptied:
    """The samples of one entry that are left empty."""

    empty: Bool[np.ndarray, "used columns"]
    reasons: dict[str, dict[str, int]]
    """How many samples, by sensor and reason."""

    @classmethod
    def of(cls, used: Timed) -> "Emptied":
        """What is found among all samples, in the order of their times."""
        names = used.values.entry.columns
        groups = [
            (sensor, [names.index(name) for name in columns])
            for sensor, columns in sensor_groups(names).items()
        ]
        empty = np.zeros((used.order.size, len(names)), dtype=bool)
        reasons = defaultdict[str, Counter[str]](Counter)
        if used.values.zeros:
            reasons["attitude"]["quaternion of zeros"] = used.values.zeros
        for start in range(0, used.order.size, _LOOKED_AT):
            rows = slice(start, start + _LOOKED_AT)
            block = used.values.rows.gather(used.order[rows])
            for sensor, columns in groups:
                for reason, mask in no_measurements(sensor, block[:, columns]).items():
                    empty[start + np.flatnonzero(mask)[:, None], columns] = True
                    reasons[sensor][reason] += int(mask.sum())
        return cls(empty, {sensor: dict(why) for sensor, why in reasons.items()})

    def without(
        self, values: Float[np.ndarray, "n columns"], rows: slice
    ) -> Float[np.ndarray, "n columns"]:
        """These samples, those that are no measurement as NaN."""
        return np.where(self.empty[rows], np.nan, values)


_BLOCK_ROWS = 32_768
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
        missing = {
            number: found
            for number, entry in enumerate(entries)
            if is_preset and (found := missing_of(entry, source.topics))
        }
        if len(missing) == len(entries):
            raise InputError(
                f"{source.path}: has none of the topics of {mapped}, only "
                f"{listed(source.topics)}; write a map: 'orbident topics' proposes one"
            )
        tracks = [
            Track(entry, out)
            for number, entry in enumerate(entries)
            if number not in missing
        ]
        try:
            _collect(source, tracks, mapped, said)
            place = str(source.path)
            used = [timed(track.finished(place), place) for track in tracks]
            check_times(place, used)
            report = _written(used, str(file), out, said)
        finally:
            for track in tracks:
                track.rows.close()
    left_out = [
        f"{mapped}: the file has no {kind} {listed(dict.fromkeys(names))}: left out"
        for kind in ("topic", "field")
        if (names := [name for what, name in missing.values() if what == kind])
    ]
    warnings = (*source.notes, *left_out, *report.warnings)
    return dataclasses.replace(report, warnings=warnings)


def _collect(
    source: Source, tracks: Sequence[Track], place: str, said: Callable[[float], None]
) -> None:
    """All samples to the tracks of their topics; three quarters of the work."""
    fed: dict[str, list[Track]] = defaultdict(list)
    for number, track in enumerate(tracks):
        entry = track.entry
        found = source.topic(entry.topic).type
        if found != entry.type:
            raise InputError(
                f"{place}: topics[{number}] ({entry.topic}): type: found {entry.type}, "
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
            said(min(0.75 * done / total, 0.75))
            told = done + _SAID_EVERY


def _written(
    used: Sequence[Timed], file: str, out: Path, said: Callable[[float], None]
) -> ConversionReport:
    rows, indices = common_rows([each.stamps for each in used])
    names = ["t", *(name for each in used for name in each.values.entry.columns)]
    emptied = [Emptied.of(each) for each in used]
    write_blocks(out, names, _blocks(used, emptied, rows, indices, said))
    start_ns = int(rows[0])
    topics = tuple(
        topic_report(each, start_ns, gaps.reasons)
        for each, gaps in zip(used, emptied, strict=True)
    )
    return ConversionReport(
        file=file,
        recording=str(out),
        samples=rows.size,
        start_ns=start_ns,
        duration=float(rows[-1] - rows[0]) / 1e9,
        topics=topics,
        warnings=apart(topics),
    )


def _blocks(
    used: Sequence[Timed],
    emptied: Sequence[Emptied],
    rows: np.ndarray,
    indices: Sequence[np.ndarray],
    said: Callable[[float], None],
) -> Iterator[np.ndarray]:
    widths = [len(each.values.entry.columns) for each in used]
    edges = np.cumsum([1, *widths])
    for start in range(0, rows.size, _BLOCK_ROWS):
        stop = min(start + _BLOCK_ROWS, rows.size)
        block = np.full((stop - start, int(edges[-1])), np.nan)
        block[:, 0] = (rows[start:stop] - rows[0]) / 1e9
        for k, each in enumerate(used):
            low, high = np.searchsorted(indices[k], [start, stop])
            values = each.values.rows.gather(each.order[low:high])
            values = emptied[k].without(values, slice(low, high))
            block[indices[k][low:high] - start, edges[k] : edges[k + 1]] = values
        yield block
        said(0.75 + 0.25 * stop / rows.size)
