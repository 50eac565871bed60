"""CSV files into columns of float64."""

import codecs
import csv
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
from orbident.recordings.columns import check_names, is_known
from orbident.recordings.text_dialect import SI, TextDialect, opened_table, text_dialect

_BLOCK_BYTES = 1 << 20
# Arrow trims blanks around numbers, but not before it compares with these.
_EMPTY = ["nan", "NaN", *(" " * width for width in range(33))]
_CELL = re.compile(
    r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|[+-]?(nan|inf|infinity)|",
    re.ASCII | re.IGNORECASE,
)


def read_csv(path: Path) -> dict[str, np.ndarray]:
    """Every column of the file, empty cells as NaN; blank lines are skipped.

    Raises:
        InputError: The header is missing or refused, or a cell is not a number.
    """
    dialect = _checked_dialect(path)
    lines, start = csv_lines(path), 0
    columns = {name: np.empty(lines) for name in dialect.names}
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
    dialect = _checked_dialect(path)
    chosen = [name for name in dialect.names if wanted(name)]
    try:
        yield from _batches(path, dialect, chosen)
    except pa.ArrowException as error:
        with suppress(csv.Error):
            _explain(path, dialect)
        raise InputError(
            f"{path}: is not a readable CSV file ({str(error).splitlines()[0]})"
        ) from error


def _checked_dialect(path: Path) -> TextDialect:
    """How the file is written, its names and units those of a recording."""
    dialect = text_dialect(path)
    if not dialect.names:
        raise InputError(
            f"{path}: line {dialect.lines + 1} holds numbers where the column names "
            "should be; add a first line such as t,joint.joint1.position"
        )
    check_names(str(path), dialect.names)
    for name, unit in zip(dialect.names, dialect.units, strict=True):
        if unit and is_known(name) and unit not in SI:
            raise InputError(
                f"{path}: column '{name}' is in {unit}; a recording is in SI units: "
                "let 'orbident topics' and 'orbident convert' make one of this file"
            )
    return dialect


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


def _batches(
    path: Path, dialect: TextDialect, chosen: Sequence[str]
) -> Iterator[dict[str, np.ndarray]]:
    read = arrow_csv.ReadOptions(
        column_names=dialect.names, skip_rows=dialect.lines, block_size=_BLOCK_BYTES
    )
    convert = arrow_csv.ConvertOptions(
        column_types=dict.fromkeys(dialect.names, pa.float64()),
        null_values=_EMPTY,
        include_columns=chosen,
        decimal_point=dialect.decimal_point,
    )
    with (
        opened_table(path, dialect) as file,
        arrow_csv.open_csv(file, read, dialect.parse_options(), convert) as reader,
    ):
        for batch in reader:
            yield {
                name: values.to_numpy(zero_copy_only=False)
                for name, values in zip(chosen, batch.columns, strict=True)
            }


def _explain(path: Path, dialect: TextDialect) -> None:
    """Finds the first thing wrong, slowly; Arrow does not say where it is."""
    with path.open(encoding="utf-8-sig", errors="replace", newline="") as file:
        number = 0
        for number, row in enumerate(dialect.rows(file), 1):
            _check_row(path, dialect, number, row)
    if not number:
        raise InputError(f"{path}: has column names but no rows; add the samples")


def _check_row(
    path: Path, dialect: TextDialect, number: int, row: Sequence[str]
) -> None:
    names = dialect.names
    if len(row) != len(names):
        raise InputError(
            f"{path}: row {number} has {len(row)} cells but the header names "
            f"{len(names)} columns; make them equal"
        )
    for name, cell in zip(names, row, strict=True):
        if not _CELL.fullmatch(cell.strip().replace(dialect.decimal_point, ".")):
            wanted = "a number, or leave the cell empty"
            if name == "t":
                wanted = "the time in seconds, or let 'orbident convert' read dates"
            raise InputError(
                f"{path}: column '{name}', row {number}: found {quoted(cell)}; "
                f"give {wanted}"
            )
