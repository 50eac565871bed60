"""Parquet files with columns of any names."""

import os
import re
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute
import pyarrow.parquet as parquet

from orbident.errors import InputError
from orbident.files.names import first_duplicate, quoted
from orbident.recordings.logs.group import LogField, Tree, field_of, unusable

# Its functions are made when it is imported, where no type checker sees them.
pc: Any = pyarrow.compute
_FORMATS = (
    "%Y-%m-%dT%H:%M:%S",
    "%Y-%m-%d %H:%M:%S",
    "%Y/%m/%d %H:%M:%S",
    "%Y-%jT%H:%M:%S",
    "%b %d %Y %H:%M:%S",
    "%d %b %Y %H:%M:%S",
)
"""Of dates whose day and month cannot be taken for each other."""
_PARTS = r"^(?P<whole>.*:\d\d)(?P<fraction>[.,]\d{1,9})?Z?$"
_VECTOR = re.compile(r"\s*[\[({](.*)[\])}]\s*")


def fields_of(
    columns: Sequence[pa.ChunkedArray],
    names: Sequence[str],
    units: Sequence[str],
    place: str,
) -> Tree:
    """Columns by their names.

    Args:
        columns: of a table.
        names: of the columns; blanks at their ends do not count.
        units: of the columns; empty where the file tells none.
        place: the file, for messages.

    Raises:
        InputError: a name is given twice.
    """
    names = [name.strip() for name in names]
    twice = first_duplicate(names)
    if twice is not None:
        raise InputError(f"{place}: two columns are named '{twice}'; rename one")
    return {
        name: _field(column, unit)
        for name, column, unit in zip(names, columns, units, strict=True)
    }


def _field(column: pa.ChunkedArray, unit: str) -> LogField | Tree:
    kinds = pa.types
    if kinds.is_string(column.type) or kinds.is_large_string(column.type):
        return _of_text(column)
    if kinds.is_date(column.type) or kinds.is_timestamp(column.type):
        return _plain(column.cast(pa.timestamp("ns")).cast(pa.int64()), "ns")
    if kinds.is_time(column.type):
        return _plain(column.cast(pa.time64("ns")).cast(pa.int64()), "ns")
    if kinds.is_null(column.type) or kinds.is_decimal(column.type):
        return _plain(column.cast(pa.float64()), unit)
    return _plain(column, unit)


def _plain(column: pa.ChunkedArray, unit: str) -> LogField | Tree:
    if column.null_count and not pa.types.is_floating(column.type):
        column = column.cast(pa.float64())
    values = column.to_numpy()
    return field_of(values.shape, values.dtype, lambda: values, unit)


def _of_text(column: pa.ChunkedArray) -> LogField | Tree:
    """Times, or vectors; any other text is no number."""
    row, text = _first_text(column)
    if _VECTOR.fullmatch(text):
        return _vectors(column.to_pylist())
    times = _times(column)
    if times is not None:
        return _plain(times, "ns")
    return unusable(
        f"holds text: {quoted(text)} in row {row}; write numbers, or leave the "
        "cell empty"
    )


def _first_text(column: pa.ChunkedArray) -> tuple[int, Any]:
    """The first cell that is no number, and its row, counted from 1."""
    for row, cell in enumerate(column.to_pylist(), 1):
        try:
            np.float64(cell or 0)
        except ValueError:
            return row, cell
    return 1, column[0].as_py()


def _times(column: pa.ChunkedArray) -> pa.ChunkedArray | None:
    """Dates and times of day, ns since 1970 or since midnight; None if any is none."""
    parts = pc.extract_regex(pc.replace_substring(column, "_", " "), _PARTS)
    whole = pc.struct_field(parts, "whole")
    if whole.null_count > column.null_count:
        return None
    digits = pc.utf8_slice_codeunits(pc.struct_field(parts, "fraction"), 1)
    padded = pc.utf8_rpad(pc.fill_null(digits, ""), 9, "0")
    dated = pc.binary_join_element_wise("1970-01-01", whole, "T")
    for text, formats in ((whole, _FORMATS), (dated, _FORMATS[:1])):
        for each in formats:
            times = pc.strptime(text, each, "s", error_is_null=True)
            if times.null_count == column.null_count:
                seconds = times.cast(pa.timestamp("ns")).cast(pa.int64())
                return pc.add(seconds, padded.cast(pa.int64()))
    return None


def _vectors(cells: Sequence[str | None]) -> LogField | Tree:
    """`[1, 0, 1]` in every cell as rows of a matrix; an empty cell has no numbers."""
    rows: list[list[str]] = []
    width = 0
    for number, cell in enumerate(cells, 1):
        found = _VECTOR.fullmatch(cell or "[]")
        row = re.split(r"[,;\s]+", found[1].strip()) if found else []
        width = width or (len(row) if cell else 0)
        if cell and len(row) != width:
            return unusable(
                f"holds {quoted(cell)} in row {number}, which is no vector of {width} "
                "numbers as the ones before; write as many in every cell"
            )
        rows.append(row if cell else ["nan"] * width)
    try:
        values = np.array(rows, dtype=np.float64)
    except ValueError:
        return unusable("holds vectors of text; write numbers in them")
    return field_of(values.shape, values.dtype, lambda: values)


def read_parquet_log(path: Path, stack: ExitStack) -> Tree:
    """Columns by name."""
    del stack
    with pa.OSFile(os.fsencode(path)) as file:
        table = parquet.read_table(file)
    names = table.column_names
    return fields_of(table.columns, names, [""] * len(names), str(path))
