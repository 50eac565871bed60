"""A bag into a recording, in bounded memory."""

import os
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np

from orbident.errors import InputError
from orbident.recordings.bags.bag import Bag, open_bag
from orbident.recordings.bags.common_rows import common_rows
from orbident.recordings.bags.entry import Entry
from orbident.recordings.bags.report import ConversionReport, apart, topic_report
from orbident.recordings.bags.timing import Timed, check_times, timed
from orbident.recordings.bags.topic_map import load_topic_map
from orbident.recordings.bags.track import Track
from orbident.recordings.table_writer import write_blocks
from orbident.recordings.tables import check_writable

_BLOCK_ROWS = 32_768
_SAID_EVERY = 4096


def convert_bag(
    bag: str | os.PathLike[str],
    topic_map: str | os.PathLike[str],
    recording: str | os.PathLike[str],
    progress: Callable[[float], None] | None = None,
) -> ConversionReport:
    """Writes a bag's mapped topics as a recording, .parquet or .csv.

    Rows are the union of all stamps; `t` is 0 at the first. Values wait in files
    without names beside the recording: memory holds their times only.

    Args:
        bag: a ROS 1 bag, a ROS 2 bag, or an MCAP file.
        topic_map: what each topic feeds.
        recording: where to; replaced if it exists.
        progress: called with the fraction done.

    Returns:
        What became of every message.

    Raises:
        InputError: The bag, the map or the place cannot be used, or they do not fit
            together. One line: file, place, what was found, what to do.
    """
    out = Path(recording)
    check_writable(out)
    entries = load_topic_map(Path(topic_map))
    said = progress or (lambda fraction: None)
    with open_bag(Path(bag)) as opened:
        tracks = [Track(entry, out) for entry in entries]
        try:
            _collect(opened, tracks, str(topic_map), said)
            used = [timed(track.finished(str(opened.path))) for track in tracks]
            check_times(str(opened.path), used)
            return _written(used, str(bag), out, said)
        finally:
            for track in tracks:
                track.rows.close()


def _collect(
    bag: Bag, tracks: Sequence[Track], place: str, said: Callable[[float], None]
) -> None:
    """All messages to the tracks of their topics; three quarters of the work."""
    fed: dict[str, list[Track]] = defaultdict(list)
    for number, track in enumerate(tracks):
        _check_type(bag, track.entry, f"{place}: topics[{number}]")
        fed[track.entry.topic].append(track)
    decoders = {name: bag.topics[name].decoder(str(bag.path)) for name in fed}
    total = sum(bag.topics[name].count for name in fed)
    for number, (topic, received, data) in enumerate(bag.messages(fed)):
        message = decoders[topic](data)
        for track in fed[topic]:
            if message is None:
                track.skip()
            else:
                track.add(received, message)
        if number % _SAID_EVERY == 0:
            said(min(0.75 * number / total, 0.75))


def _check_type(bag: Bag, entry: Entry, place: str) -> None:
    found = bag.topic(entry.topic).type
    if found != entry.type:
        raise InputError(
            f"{place}: type: found {entry.type}, but '{entry.topic}' has {found} in "
            f"{bag.path}; correct it"
        )


def _written(
    used: Sequence[Timed], bag: str, out: Path, said: Callable[[float], None]
) -> ConversionReport:
    rows, places = common_rows([each.stamps for each in used])
    names = ["t", *(name for each in used for name in each.values.entry.columns)]
    write_blocks(out, names, _blocks(used, rows, places, said))
    start_ns = int(rows[0])
    topics = tuple(topic_report(each, start_ns) for each in used)
    return ConversionReport(
        bag=bag,
        recording=str(out),
        samples=rows.size,
        start_ns=start_ns,
        duration=float(rows[-1] - rows[0]) / 1e9,
        topics=topics,
        warnings=apart(topics),
    )


def _blocks(
    used: Sequence[Timed],
    rows: np.ndarray,
    places: Sequence[np.ndarray],
    said: Callable[[float], None],
) -> Iterator[np.ndarray]:
    widths = [len(each.values.entry.columns) for each in used]
    edges = np.cumsum([1, *widths])
    for start in range(0, rows.size, _BLOCK_ROWS):
        stop = min(start + _BLOCK_ROWS, rows.size)
        block = np.full((stop - start, int(edges[-1])), np.nan)
        block[:, 0] = (rows[start:stop] - rows[0]) / 1e9
        for k, each in enumerate(used):
            low, high = np.searchsorted(places[k], [start, stop])
            values = each.values.rows.gather(each.order[low:high])
            block[places[k][low:high] - start, edges[k] : edges[k + 1]] = values
        yield block
        said(0.75 + 0.25 * stop / rows.size)
