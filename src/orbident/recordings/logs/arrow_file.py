"""CSV and Parquet files with columns of any names."""

import os
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.csv as arrow_csv
import pyarrow.parquet as parquet

from orbident.errors import InputError
from orbident.files.names import first_duplicate, quoted
from orbident.recordings.logs.group import LogField, Tree, field_of, unusable

_EMPTY = ["", "nan", "NaN", "NAN", "null"]


def read_csv_log(path: Path, stack: ExitStack) -> Tree:
    """Columns by the names in the first line; tabs or semicolons will do as well.

    Raises:
        InputError: The first line is not UTF-8.
    """
    del stack
    with path.open("rb") as file:
        first = file.readline(2**20)
    separator = max(b",;\t", key=first.count)
    parse = arrow_csv.ParseOptions(delimiter=chr(separator))
    convert = arrow_csv.ConvertOptions(null_values=_EMPTY, strings_can_be_null=True)
    with pa.OSFile(os.fsencode(path)) as file:
        return _tree(arrow_csv.read_csv(file, None, parse, convert), path)


def read_parquet_log(path: Path, stack: ExitStack) -> Tree:
    """Columns by name."""
    del stack
    with pa.OSFile(os.fsencode(path)) as file:
        return _tree(parquet.read_table(file), path)


def _tree(table: pa.Table, path: Path) -> Tree:
    names = [name.strip() for name in table.column_names]
    twice = first_duplicate(names)
    if twice is not None:
        raise InputError(f"{path}: two columns are named '{twice}'; rename one")
    return {
        name: _field(column) for name, column in zip(names, table.columns, strict=True)
    }


def _field(column: pa.ChunkedArray) -> LogField | Tree:
    kinds = pa.types
    if kinds.is_string(column.type) or kinds.is_large_string(column.type):
        row, text = _first_text(column)
        return unusable(
            f"holds text: {quoted(text)} in row {row}; write numbers, or leave the "
            "cell empty"
        )
    if kinds.is_timestamp(column.type):
        return _plain(column.cast(pa.timestamp("ns")).cast(pa.int64()), "ns")
    if kinds.is_null(column.type) or kinds.is_decimal(column.type):
        return _plain(column.cast(pa.float64()), "")
    return _plain(column, "")


def _plain(column: pa.ChunkedArray, unit: str) -> LogField | Tree:
    if column.null_count and not pa.types.is_floating(column.type):
        column = column.cast(pa.float64())
    values = column.to_numpy()
    return field_of(values.shape, values.dtype, lambda: values, unit)


def _first_text(column: pa.ChunkedArray) -> tuple[int, Any]:
    """The first cell that is no number, and its row, counted from 1."""
    for row, cell in enumerate(column.to_pylist(), 1):
        try:
            np.float64(cell or 0)
        except ValueError:
            return row, cell
    return 1, column[0].as_py()
