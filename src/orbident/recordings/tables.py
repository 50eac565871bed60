"""Recordings as CSV and Parquet files."""

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from orbident.errors import InputError
from orbident.files.text import refuse_pipe
from orbident.recordings.columns import is_known
from orbident.recordings.csv_table import csv_batches, csv_lines, read_csv
from orbident.recordings.long_recording import LARGE, LongRecording
from orbident.recordings.parquet_table import (
    parquet_batches,
    parquet_rows,
    read_parquet,
)
from orbident.recordings.recording import Recording
from orbident.recordings.table_writer import write_blocks

SUFFIXES = (".csv", ".parquet")

_BLOCK_ROWS = 65_536


def open_recording(path: str | os.PathLike[str]) -> Recording | LongRecording:
    """Reads a recording, or leaves one of many rows where it is, to be read in parts.

    Raises:
        InputError: As `read_recording`; what is wrong in a row of a long recording is
            said once that row is read.
    """
    path = Path(path)
    with _readable(path):
        if _rows_at_most(path) < LARGE or (rows := _rows(path)) < LARGE:
            return read_recording(path)

    def batches() -> Iterator[dict[str, np.ndarray]]:
        with _readable(path):
            yield from _batches(path, is_known)

    return LongRecording(str(path), rows, batches, lambda: read_recording(path))


def read_recording(path: str | os.PathLike[str]) -> Recording:
    """Reads a recording; the suffix, .csv or .parquet, says how.

    Peak memory is the recording and one batch of rows. An empty cell and NaN mean
    no sample.

    Raises:
        InputError: The file is missing, of another kind, damaged or empty; a cell is
            not a number; a column is named twice; `t` is missing; or the values are
            refused by `Recording`.
    """
    path = Path(path)
    with _readable(path):
        columns = read_csv(path) if _is_csv(path) else read_parquet(path)
    t = columns.pop("t")
    return Recording(t=t, columns=columns, source=str(path))


@contextmanager
def _readable(path: Path) -> Iterator[None]:
    """Refuse what is no recording, or cannot be read during the block."""
    refuse_pipe(path, "the recording")
    _check_suffix(path)
    if path.is_dir():
        raise InputError(f"{path}: is a folder; give a recording")
    if not path.exists():
        raise InputError(f"{path}: does not exist; give a recording")
    try:
        if path.stat().st_size == 0:
            raise InputError(f"{path}: is empty; give a recording")
        yield
    except OSError as error:
        reason = error.strerror or str(error).splitlines()[0]
        raise InputError(f"{path}: cannot be read ({reason})") from error


def _is_csv(path: Path) -> bool:
    return path.suffix.lower() == ".csv"


def _batches(
    path: Path, wanted: Callable[[str], bool]
) -> Iterator[dict[str, np.ndarray]]:
    return csv_batches(path, wanted) if _is_csv(path) else parquet_batches(path, wanted)


def _rows_at_most(path: Path) -> int:
    """A row of CSV has two characters at least: few bytes are few rows."""
    return path.stat().st_size // 2 if _is_csv(path) else parquet_rows(path)


def _rows(path: Path) -> int:
    if not _is_csv(path):
        return parquet_rows(path)
    if csv_lines(path) < LARGE:
        return 0
    return sum(batch["t"].size for batch in csv_batches(path, {"t"}.__contains__))


def write_recording(recording: Recording, path: str | os.PathLike[str]) -> None:
    """Writes a recording as .csv or .parquet; reading it gives the same bits.

    An existing file is replaced, and only once the new one is complete. NaN becomes
    an empty cell.

    Raises:
        InputError: Another suffix, a folder that does not exist, or no permission.
    """
    path = Path(path)
    _check_suffix(path)
    write_blocks(path, ("t", *recording.columns), _blocks(recording))


def check_writable(path: str | os.PathLike[str]) -> None:
    """Refuse a place for a recording before it is made, not after.

    Raises:
        InputError: Another suffix, or a folder that does not exist.
    """
    path = Path(path)
    _check_suffix(path)
    if not path.parent.is_dir():
        raise InputError(f"{path}: folder '{path.parent}' does not exist; create it")


def _check_suffix(path: Path) -> None:
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(
            f"{path}: the name of a recording ends in {' or '.join(SUFFIXES)}; give "
            "such a file"
        )


def _blocks(recording: Recording) -> Iterator[np.ndarray]:
    columns = (recording.t, *recording.columns.values())
    for start in range(0, recording.t.size, _BLOCK_ROWS):
        rows = slice(start, start + _BLOCK_ROWS)
        yield np.column_stack([column[rows] for column in columns])
