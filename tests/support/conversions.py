"""A bag and a map in a folder, converted, and the table read again."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from bag_writers import Sent, write_bag

from orbident.errors import InputError
from orbident.recordings.recording import Recording
from orbident.recordings.tables import read_recording
from orbident.recordings.topics.convert import ConversionReport, convert_file
from orbident.recordings.topics.topic_map import load_topic_map

HEAD = "schema: orbident/topic-map/1\ntopics:\n"


def refusal(folder: Path, entry: str) -> str:
    """What is said of a map with this one entry, after its file and line."""
    path = folder / "map.yaml"
    path.write_text(f"{HEAD}  - {entry}\n")
    with pytest.raises(InputError) as raised:
        load_topic_map(path)
    line = str(raised.value)
    assert "\n" not in line
    place, said = line.split(": ", 1)
    assert place.startswith(f"{path}:")
    assert int(place.removeprefix(f"{path}:")) > 2
    return said


def converted(
    folder: Path,
    sent: Sequence[Sent],
    entries: str,
    kind: str = "mcap-ros2",
    suffix: str = ".parquet",
) -> tuple[Recording, ConversionReport]:
    """What is read after conversion, and the report.

    Args:
        folder: for the files.
        sent: the messages, in the order in which the bag has them.
        entries: of the map, YAML without the head.
        kind: of bag.
        suffix: of the recording.
    """
    bag = write_bag(kind, folder, sent)
    topic_map = folder / "map.yaml"
    topic_map.write_text(HEAD + entries)
    out = folder / f"recording{suffix}"
    report = convert_file(bag, topic_map, out)
    return read_recording(out), report


def cells(recording: Recording, prefix: str, axes: str) -> np.ndarray:
    """A vector's samples, rows without one left out."""
    table = recording.vector(prefix, axes)
    return table[~np.isnan(table).all(axis=1)]
