"""Recordings as CSV and Parquet files."""

import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from orbident.errors import InputError
from orbident.recordings.csv_table import read_csv
from orbident.recordings.parquet_table import read_parquet
from orbident.recordings.recording import Recording
from orbident.recordings.table_writer import write_blocks

SUFFIXES = (".csv", ".parquet")

_BLOCK_ROWS = 65_536


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
    _check_suffix(path)
    if path.is_dir():
        raise InputError(f"{path}: is a folder; give a recording")
    if not path.exists():
        raise InputError(f"{path}: does not exist; give a recording")
    try:
        if path.stat().st_size == 0:
            raise InputError(f"{path}: is empty; give a recording")
        read = read_csv if path.suffix.lower() == ".csv" else read_parquet
        columns = read(path)
    except OSError as error:
        reason = error.strerror or str(error).splitlines()[0]
        raise InputError(f"{path}: cannot be read ({reason})") from error
    t = columns.pop("t")
    return Recording(t=t, columns=columns, source=str(path))


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
            f"{path}: suffix '{path.suffix}' is not supported; "
            f"use {' or '.join(SUFFIXES)}"
        )


def _blocks(recording: Recording) -> Iterator[np.ndarray]:
    columns = (recording.t, *recording.columns.values())
    for start in range(0, recording.t.size, _BLOCK_ROWS):
        rows = slice(start, start + _BLOCK_ROWS)
        yield np.column_stack([column[rows] for column in columns])
