"""Recordings as CSV and Parquet files."""

import csv
import io
import os
from collections.abc import Iterator
from pathlib import Path

import pyarrow as pa
import pyarrow.csv as arrow_csv
import pyarrow.parquet as parquet

from orbident.errors import InputError
from orbident.files.replacing import replacing
from orbident.recordings.csv_table import read_csv
from orbident.recordings.parquet_table import read_parquet
from orbident.recordings.recording import Recording

SUFFIXES = (".csv", ".parquet")

_BATCH_ROWS = 65_536


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
    schema = pa.schema([(name, pa.float64()) for name in ("t", *recording.columns)])
    with replacing(path) as temporary:
        if path.suffix.lower() == ".csv":
            _write_csv(recording, schema, temporary)
        else:
            _write_parquet(recording, schema, temporary)


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


def _batches(recording: Recording, schema: pa.Schema) -> Iterator[pa.RecordBatch]:
    columns = (recording.t, *recording.columns.values())
    for start in range(0, recording.t.size, _BATCH_ROWS):
        rows = slice(start, start + _BATCH_ROWS)
        arrays = [pa.array(column[rows], from_pandas=True) for column in columns]
        yield pa.RecordBatch.from_arrays(arrays, schema=schema)


def _write_csv(recording: Recording, schema: pa.Schema, path: Path) -> None:
    header = io.StringIO()
    csv.writer(header, lineterminator="\n").writerow(schema.names)
    # Arrow prints the shortest decimal that reads back as the same float64.
    options = arrow_csv.WriteOptions(include_header=False)
    with pa.OSFile(str(path), "wb") as sink:
        sink.write(header.getvalue().encode())
        with arrow_csv.CSVWriter(sink, schema, write_options=options) as writer:
            for batch in _batches(recording, schema):
                writer.write_batch(batch)


def _write_parquet(recording: Recording, schema: pa.Schema, path: Path) -> None:
    # Measured values hardly repeat: a dictionary would cost time and memory only.
    with parquet.ParquetWriter(
        str(path), schema, compression="zstd", use_dictionary=False
    ) as writer:
        for batch in _batches(recording, schema):
            writer.write_batch(batch)
