"""Parquet files into columns of float64."""

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as parquet

from orbident.errors import InputError
from orbident.files.names import quoted
from orbident.recordings.columns import check_names

_BATCH_ROWS = 16_384


def read_parquet(path: Path) -> dict[str, np.ndarray]:
    """Every column of the file, nulls as NaN.

    Raises:
        InputError: The file is damaged, lacks `t`, names a column twice, or has a
            column that is not numeric.
    """
    with _opened(path) as file:
        names, start = file.schema_arrow.names, 0
        columns = {name: np.empty(file.metadata.num_rows) for name in names}
        for batch in _batches(file, names):
            rows = slice(start, start + batch["t"].size)
            for name, values in batch.items():
                columns[name][rows] = values
            start = rows.stop
        if start != file.metadata.num_rows:
            raise pa.ArrowInvalid(f"{start} of {file.metadata.num_rows} rows found")
    return columns


def parquet_batches(
    path: Path, wanted: Callable[[str], bool]
) -> Iterator[dict[str, np.ndarray]]:
    """The columns that are wanted, some thousand rows at a time.

    Raises:
        InputError: As `read_parquet`.
    """
    with _opened(path) as file:
        yield from _batches(file, [n for n in file.schema_arrow.names if wanted(n)])


def parquet_rows(path: Path) -> int:
    """How many rows the file says that it has.

    Raises:
        InputError: As `read_parquet`.
    """
    with _opened(path) as file:
        return file.metadata.num_rows


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


def _batches(
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
