"""CSV files into columns of float64."""

import codecs
import csv
import os
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from itertools import chain
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv as arrow_csv

from orbident.errors import InputError
from orbident.files.names import quoted
from orbident.recordings.columns import check_names

_BLOCK_BYTES = 1 << 20
# Arrow trims blanks around numbers, but not before it compares with these.
_EMPTY = ["nan", "NaN", *(" " * width for width in range(33))]
_NUMBER = re.compile(
    r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|[+-]?(nan|inf|infinity)|",
    re.ASCII | re.IGNORECASE,
)


def read_csv(path: Path) -> dict[str, np.ndarray]:
    """Every column of the file, empty cells as NaN; blank lines are skipped.

    Raises:
        InputError: The header is missing or refused, or a cell is not a number.
    """
    names, _ = _header(path)
    lines, start = csv_lines(path), 0
    columns = {name: np.empty(lines) for name in names}
    for batch in csv_batches(path):
        rows = slice(start, start + batch["t"].size)
        for name, values in batch.items():
            columns[name][rows] = values
        start = rows.stop
    pa.default_memory_pool().release_unused()
    return {name: values[:start] for name, values in columns.items()}


def csv_batches(
    path: Path, wanted: Callable[[str], bool] = lambda _: True
) -> Iterator[dict[str, np.ndarray]]:
    """The columns that are wanted, some thousand rows at a time.

    Raises:
        InputError: As `read_csv`.
    """
    names, header_lines = _header(path)
    _check_separator(path, names)
    check_names(str(path), names)
    chosen = [name for name in names if wanted(name)]
    try:
        yield from _batches(path, names, chosen, header_lines)
    except pa.ArrowException as error:
        with suppress(csv.Error):
            _explain(path, names)
        raise InputError(
            f"{path}: is not a readable CSV file ({str(error).splitlines()[0]})"
        ) from error


def _header(path: Path) -> tuple[list[str], int]:
    """The names, and how many lines of the file they take."""
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            reader = csv.reader(file)
            header = next((row for row in reader if not _is_blank(row)), [])
            lines = reader.line_num
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(
            f"{path}: is not UTF-8 text with comma-separated cells; "
            "export it as CSV in UTF-8"
        ) from error
    names = [name.strip() for name in header]
    if not names:
        raise InputError(f"{path}: is empty; the first line must name the columns")
    if all(_NUMBER.fullmatch(name) for name in names):
        raise InputError(
            f"{path}: line {lines} holds numbers where the column names should be; "
            "add a first line such as t,joint.joint1.position"
        )
    return names, lines


def _check_separator(path: Path, names: Sequence[str]) -> None:
    """Name what stands between the cells where it is no comma."""
    header = ",".join(names)
    for separator, called in (("\t", "tabs"), (";", "semicolons")):
        cells = [cell.strip() for cell in header.split(separator)]
        if "t" not in names and "t" in cells and len(cells) > len(names):
            raise InputError(
                f"{path}: the cells are separated by {called}; export it with commas "
                "between the cells, and with points in the numbers"
            )


def csv_lines(path: Path) -> int:
    """An upper bound of the number of rows.

    Rows that do not come stay untouched pages: they cost address space, not memory.

    Raises:
        InputError: a byte is not UTF-8.
    """
    text, line_feeds, returns = codecs.getincrementaldecoder("utf-8")(), 0, 0
    with path.open("rb") as file:
        # An empty block at last: a character may be cut off.
        for block in chain(iter(lambda: file.read(_BLOCK_BYTES), b""), [b""]):
            try:
                text.decode(block, final=not block)
            except UnicodeDecodeError as error:
                found, at = error.object, error.start
                line = 1 + line_feeds + found.count(b"\n", 0, at)
                raise InputError(
                    f"{path}: line {line}: byte 0x{found[at]:02x} is not UTF-8; export "
                    "it as CSV in UTF-8"
                ) from None
            line_feeds += block.count(b"\n")
            returns += block.count(b"\r")
    return 1 + line_feeds + returns


def _skip_blank(row: arrow_csv.InvalidRow) -> str:
    return "error" if row.text.strip() else "skip"


def _batches(
    path: Path, names: Sequence[str], chosen: Sequence[str], header_lines: int
) -> Iterator[dict[str, np.ndarray]]:
    number = pa.float64()
    read = arrow_csv.ReadOptions(
        column_names=names, skip_rows=header_lines, block_size=_BLOCK_BYTES
    )
    parse = arrow_csv.ParseOptions(invalid_row_handler=_skip_blank)
    convert = arrow_csv.ConvertOptions(
        column_types=dict.fromkeys(names, number),
        null_values=_EMPTY,
        include_columns=chosen,
    )
    # Bytes: as text Arrow takes no name that is not UTF-8.
    with (
        pa.OSFile(os.fsencode(path)) as file,
        arrow_csv.open_csv(file, read, parse, convert) as reader,
    ):
        for batch in reader:
            yield {
                name: values.to_numpy(zero_copy_only=False)
                for name, values in zip(chosen, batch.columns, strict=True)
            }


def _explain(path: Path, names: Sequence[str]) -> None:
    """Finds the first thing wrong, slowly; Arrow does not say where it is."""
    with path.open(encoding="utf-8-sig", errors="replace", newline="") as file:
        lines = (row for row in csv.reader(file) if not _is_blank(row))
        next(lines)
        row = next(lines, None)
        if row is None:
            raise InputError(f"{path}: has column names but no rows; add the samples")
        number = 1
        while row is not None:
            _check_row(path, names, number, row)
            number += 1
            row = next(lines, None)


def _is_blank(row: list[str]) -> bool:
    return not row or (len(row) == 1 and not row[0].strip())


def _check_row(path: Path, names: Sequence[str], number: int, row: list[str]) -> None:
    if len(row) != len(names):
        raise InputError(
            f"{path}: row {number} has {len(row)} cells but the header names "
            f"{len(names)} columns; make them equal"
        )
    for name, cell in zip(names, row, strict=True):
        if not _NUMBER.fullmatch(cell.strip()):
            raise InputError(
                f"{path}: column '{name}', row {number}: found {quoted(cell)}; "
                "give a number, or leave the cell empty"
            )
