"""Tables of Parquet and of text: one table a file, or one signal a file."""

import os
import re
from collections.abc import Sequence
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute
import pyarrow.csv as arrow_csv
import pyarrow.parquet as parquet

from orbident.errors import InputError
from orbident.files.names import first_duplicate, one_line, quoted
from orbident.recordings.csv_table import (
    TextDialect,
    csv_lines,
    opened_table,
    text_dialect,
)
from orbident.recordings.logs.group import LogField, Tree, in_memory, unusable

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

    Blanks at the ends of a name do not count; a unit is empty where the file tells
    none.

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
    return in_memory(column.to_numpy(), unit)


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
        return in_memory(np.array(rows, dtype=np.float64))
    except ValueError:
        return unusable("holds vectors of text; write numbers in them")


def read_parquet_log(path: Path, stack: ExitStack) -> Tree:
    """Columns by name."""
    with pa.OSFile(os.fsencode(path)) as file:
        table = parquet.read_table(file)
    names = table.column_names
    return fields_of(table.columns, names, [""] * len(names), str(path))


SUFFIXES = (".42", ".csv", ".tsv", ".txt", ".dat")
_EMPTY = ["", "nan", "NaN", "NAN", "null"]


def read_text_table(path: Path, stack: ExitStack) -> Tree:
    """Columns by name; those without names are `qbn.0`, `qbn.1` of a file `qbn.42`.

    Raises:
        InputError: the first lines are not UTF-8, a row has another number of cells, or
            a name is given twice.
    """
    dialect = text_dialect(path)
    try:
        table = _table(path, dialect, arrow_csv.ParseOptions(delimiter=dialect.mark))
    except pa.ArrowInvalid:
        # Arrow gives no row that is not UTF-8 to what leaves rows out.
        csv_lines(path)
        try:
            table = _table(path, dialect, dialect.parse_options())
        except pa.ArrowInvalid:
            _refuse_uneven(path, dialect)
            raise
    columns, width = table.columns, table.num_columns
    names = dialect.names or tuple(str(k) for k in range(width))
    fields = fields_of(columns, names, dialect.units or [""] * width, str(path))
    if dialect.names:
        return fields
    return {path.stem: fields if width > 1 else fields["0"]}


def text_tables_in(folder: Path) -> list[Path]:
    """The tables of a folder that has one signal a file, as those of NASA's 42."""
    # What cannot be looked into is refused by whoever opens it.
    with suppress(OSError):
        files = [each for each in sorted(folder.iterdir()) if each.is_file()]
        for suffix in SUFFIXES:
            if found := [each for each in files if each.suffix.lower() == suffix]:
                return found
    return []


def read_text_folder(path: Path, stack: ExitStack) -> Tree:
    """Every table under the name of its file; `time.42` is the time of the others.

    A file that is no table is a field that cannot be used, which says why.
    """
    tree = {}
    for each in text_tables_in(path):
        # As 42 leaves it where the robot has no such sensor.
        if not each.stat().st_size:
            continue
        try:
            fields = read_text_table(each, stack)
        except (InputError, pa.ArrowInvalid) as error:
            reason = one_line(error).removeprefix(f"{each}: ")
            fields = {each.stem: unusable(f"cannot be read: {reason}")}
        tree[each.stem] = fields.get(each.stem, fields)
    return tree


def _table(path: Path, dialect: TextDialect, parse: arrow_csv.ParseOptions) -> pa.Table:
    read = arrow_csv.ReadOptions(
        column_names=dialect.names,
        autogenerate_column_names=not dialect.names,
        skip_rows=dialect.lines,
    )
    convert = arrow_csv.ConvertOptions(
        null_values=_EMPTY,
        strings_can_be_null=True,
        decimal_point=dialect.decimal_point,
    )
    with opened_table(path, dialect) as file:
        return arrow_csv.read_csv(file, read, parse, convert)


def _refuse_uneven(path: Path, dialect: TextDialect) -> None:
    width = len(dialect.names)
    with path.open(encoding="utf-8-sig", errors="replace", newline="") as file:
        for number, row in enumerate(dialect.rows(file), 1):
            width = width or len(row)
            if len(row) != width:
                raise InputError(
                    f"{path}: row {number} has {len(row)} cells where {width} are "
                    "expected; make them equal, or write the file again"
                )
