"""Recordings as CSV and Parquet files, block by block, written whole or not at all."""

import csv
import io
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv as arrow_csv
import pyarrow.parquet as parquet

from orbident.errors import InputError
from orbident.files.names import quoted
from orbident.files.replacing import check_place, replacing
from orbident.files.text import refuse_pipe, unreadable
from orbident.recordings.columns import check_names, is_known
from orbident.recordings.csv_table import (
    csv_batches,
    csv_lines,
    joined_batches,
    read_csv,
)
from orbident.recordings.long_recording import LARGE, LongRecording
from orbident.recordings.recording import NamedColumns, Recording


def write_blocks(
    path: Path, names: Sequence[str], blocks: Iterable[np.ndarray]
) -> None:
    """Writes a table as .csv or .parquet, whole or not at all; NaN is an empty cell.

    The suffix says how. Blocks are rows by columns, in order.

    Raises:
        InputError: a folder that does not exist, or no permission.
    """
    schema = pa.schema([(name, pa.float64()) for name in names])
    with (
        replacing(path) as temporary,
        # Bytes: as text Arrow takes no name that is not UTF-8.
        pa.OSFile(os.fsencode(temporary), "wb") as sink,
        _writer(path, sink, schema) as writer,
    ):
        for block in blocks:
            columns = [pa.array(column, from_pandas=True) for column in block.T]
            writer.write_batch(pa.RecordBatch.from_arrays(columns, schema=schema))


def _writer(
    path: Path, sink: pa.NativeFile, schema: pa.Schema
) -> arrow_csv.CSVWriter | parquet.ParquetWriter:
    if path.suffix.lower() != ".csv":
        # Measured values hardly repeat: a dictionary would cost time and memory only.
        return parquet.ParquetWriter(
            sink, schema, compression="zstd", use_dictionary=False
        )
    header = io.StringIO()
    csv.writer(header, lineterminator="\n").writerow(schema.names)
    sink.write(header.getvalue().encode())
    # Arrow prints the shortest decimal that reads back as the same float64.
    options = arrow_csv.WriteOptions(include_header=False)
    return arrow_csv.CSVWriter(sink, schema, write_options=options)


_BATCH_ROWS = 16_384


def read_parquet(path: Path) -> dict[str, np.ndarray]:
    """Every column of the file, nulls as NaN.

    Raises:
        InputError: The file is damaged, lacks `t`, names a column twice, or has a
            column that is not numeric.
    """
    with _opened(path) as file:
        names, rows = file.schema_arrow.names, file.metadata.num_rows
        columns = joined_batches(names, rows, _row_groups(file, names))
        if (found := columns["t"].size) != rows:
            raise pa.ArrowInvalid(f"{found} of {rows} rows found")
    return columns


def parquet_batches(
    path: Path, wanted: Callable[[str], bool]
) -> Iterator[dict[str, np.ndarray]]:
    """The columns that are wanted, some thousand rows at a time.

    Raises:
        InputError: As `read_parquet`.
    """
    with _opened(path) as file:
        yield from _row_groups(file, [n for n in file.schema_arrow.names if wanted(n)])


@contextmanager
def _opened(path: Path) -> Iterator[parquet.ParquetFile]:
    try:
        # Bytes: as text Arrow takes no name that is not UTF-8. Buffering ahead would
        # hold the compressed file in memory as well.
        with (
            pa.OSFile(os.fsencode(path)) as source,
            parquet.ParquetFile(source, buffer_size=1 << 20, pre_buffer=False) as file,
        ):
            schema = file.schema_arrow
            check_names(str(path), schema.names)
            for field in schema:
                _check_type(path, field)
            yield file
    except InputError:
        raise
    except (pa.ArrowException, ValueError, OSError) as error:
        # Arrow takes what it cannot decode for a fault of the system; those have a
        # number.
        if isinstance(error, OSError) and error.errno:
            raise
        raise InputError(
            f"{path}: is not a readable Parquet file; write it again, or give a CSV "
            f"file (Arrow says: {quoted(str(error))})"
        ) from error


def _check_type(path: Path, field: pa.Field) -> None:
    kinds = pa.types
    numeric = (
        kinds.is_integer(field.type)
        or kinds.is_floating(field.type)
        or kinds.is_decimal(field.type)
        or kinds.is_null(field.type)
    )
    if not numeric:
        raise InputError(
            f"{path}: column '{field.name}' holds {field.type} from row 1 on; "
            "give numbers (times in seconds) or remove the column"
        )


def _row_groups(
    file: parquet.ParquetFile, names: Sequence[str]
) -> Iterator[dict[str, np.ndarray]]:
    # Threads decode whole row groups ahead, which would double the memory.
    for batch in file.iter_batches(_BATCH_ROWS, columns=names, use_threads=False):
        yield {
            name: batch.column(name)
            .cast(pa.float64(), safe=False)
            .to_numpy(zero_copy_only=False)
            for name in names
        }
        # Arrow keeps as much again as it decodes.
        pa.default_memory_pool().release_unused()


SUFFIXES = (".csv", ".parquet")

_BLOCK_ROWS = 65_536
"""What is written at once: a row group of Parquet."""


RecordingLike = Recording | LongRecording | NamedColumns | str | os.PathLike[str]
"""A recording, its columns by name, or the file that it is in."""


def recording_of(given: RecordingLike) -> Recording | LongRecording:
    """The recording that is meant.

    Raises:
        InputError: As `open_recording` and `Recording.of`, or it is no recording.
    """
    if isinstance(given, Recording | LongRecording):
        return given
    if isinstance(given, str | os.PathLike):
        return open_recording(given)
    if isinstance(given, NamedColumns):
        return Recording.of(given)
    raise InputError(
        f"found {type(given).__name__} in place of a recording; give a Recording, a "
        "file's name, a DataFrame, or columns by name"
    )


def open_recording(path: str | os.PathLike[str]) -> Recording | LongRecording:
    """Reads a recording, or leaves one of many rows where it is, to be read in parts.

    Raises:
        InputError: As `read_recording`; what is wrong in a row of a long recording is
            said once that row is read.
    """
    path = Path(path)
    with _readable(path):
        if (rows := _rows(path)) < LARGE:
            return read_recording(path)

    def batches() -> Iterator[dict[str, np.ndarray]]:
        with _readable(path):
            read = csv_batches if _is_csv(path) else parquet_batches
            yield from read(path, is_known)

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
    return Recording(t=columns.pop("t"), columns=columns, source=str(path))


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
        raise unreadable(path, error) from error


def _is_csv(path: Path) -> bool:
    return path.suffix.lower() == ".csv"


def _rows(path: Path) -> int:
    """How many rows there are; of CSV with fewer than `LARGE`, any number below it."""
    if not _is_csv(path):
        with _opened(path) as file:
            return file.metadata.num_rows
    # A row has two characters at least: few bytes are few rows.
    if path.stat().st_size // 2 < LARGE or csv_lines(path) < LARGE:
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
    columns = (recording.t, *recording.columns.values())
    blocks = (
        np.column_stack([column[start : start + _BLOCK_ROWS] for column in columns])
        for start in range(0, recording.t.size, _BLOCK_ROWS)
    )
    write_blocks(path, ("t", *recording.columns), blocks)


def check_writable(path: str | os.PathLike[str]) -> None:
    """Refuse a place for a recording before it is made, not after.

    Raises:
        InputError: Another suffix, or a folder that does not exist.
    """
    _check_suffix(Path(path))
    check_place(Path(path))


def _check_suffix(path: Path) -> None:
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(
            f"{path}: the name of a recording ends in {' or '.join(SUFFIXES)}; give "
            "such a file, which 'orbident convert' makes of others"
        )
