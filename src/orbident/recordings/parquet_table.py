"""Parquet files into columns of float64."""

import os
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
            return _filled(file, schema)
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


def _filled(file: parquet.ParquetFile, schema: pa.Schema) -> dict[str, np.ndarray]:
    columns = {name: np.empty(file.metadata.num_rows) for name in schema.names}
    start = 0
    # Threads decode whole row groups ahead, which would double the memory.
    for batch in file.iter_batches(batch_size=_BATCH_ROWS, use_threads=False):
        rows = slice(start, start + batch.num_rows)
        for name, values in zip(schema.names, batch.columns, strict=True):
            numbers = values.cast(pa.float64(), safe=False)
            columns[name][rows] = numbers.to_numpy(zero_copy_only=False)
        start += batch.num_rows
    if start != file.metadata.num_rows:
        raise pa.ArrowInvalid(f"{start} of {file.metadata.num_rows} rows found")
    pa.default_memory_pool().release_unused()
    return columns
