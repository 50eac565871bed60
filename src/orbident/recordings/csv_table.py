"""Tables of text into columns of float64, however their text is written.

What stands above the rows and between the cells is found out from the first lines.
"""

import codecs
import csv
import io
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv as arrow_csv

from orbident.errors import InputError
from orbident.files.names import quoted
from orbident.recordings.columns import (
    SI,
    check_names,
    is_known,
    split_name,
    written_unit,
)

_HEAD_BYTES = 1 << 20
"""Where the header is looked for, and what separates columns."""
_HEAD_LINES = 256
"""What stands above the rows is shorter: an export of LabVIEW has some twenty."""
_SEPARATORS = ("\t", ";", ",", " ")
"""In the order in which they are tried: numbers may have commas, and names blanks."""
_NO_TEXT = re.compile("[\0-\x08\x0e-\x1f\ufffd]")
_COMMENT = re.compile(r"\s*[#%]+\s*")
_NUMBER = re.compile(
    r"[+-]?(\d+[.,]?\d*|[.,]\d+)([eE][+-]?\d+)?|[+-]?(nan|inf|infinity)",
    re.ASCII | re.IGNORECASE,
)
_TIME_OR_VECTOR = re.compile(
    r"\d+[-/:]\d+.*|.*\d\d:\d\d.*|[\[({]\s*[-+.\d].*", re.ASCII
)
_SPACED_DATE = re.compile(
    r"\b(?:[A-Z][a-z]{2} \d\d?|\d\d? [A-Z][a-z]{2}) \d{4} (?=\d\d?:\d\d)"
)
"""As FreeFlyer (`Feb 04 2022 14:30:16.97`) and GMAT (`04 Feb 2022 ...`) write it."""
_DECIMAL = re.compile(r"\s*[+-]?\d*([.,])\d+([eE][+-]?\d+)?\s*", re.ASCII)


@dataclass(frozen=True)
class TextDialect:
    """How one table is written."""

    names: tuple[str, ...]
    """Of the columns; none where no line has them."""
    units: tuple[str, ...]
    """Of the columns, as `UNITS` names them; empty where none is known."""
    lines: int
    """Above the first row."""
    separator: str
    """Between the cells; a blank is any white space."""
    decimal_point: str

    @property
    def mark(self) -> str:
        """What stands between the cells in what `opened_table` gives."""
        return "\t" if self.separator == " " else self.separator

    def parse_options(self) -> arrow_csv.ParseOptions:
        """For Arrow; lines between the rows that are blank or comments are left out."""
        return arrow_csv.ParseOptions(
            delimiter=self.mark, invalid_row_handler=_skip_no_row
        )

    def rows(self, lines: Iterable[str]) -> Iterator[list[str]]:
        """The cells of all of the file's lines, from the first row on."""
        return (row for at, row in _rows(lines, self.separator) if at >= self.lines)


def text_dialect(path: Path) -> TextDialect:
    """What the first lines of a file tell.

    The names are in the last line of words above the first line that begins with a
    number. A line of units may stand between the two, and the names may be a comment.

    Raises:
        InputError: these lines are blank or not UTF-8, or a cell of them does not end.
    """
    with path.open("rb") as file:
        head = file.read(_HEAD_BYTES).decode("utf-8-sig", errors="replace")
    lines = list(io.StringIO(head, newline=""))
    try:
        found = [_Layout(lines[:_HEAD_LINES], each) for each in _SEPARATORS]
        # Where nothing fits, what cuts the first line most often is meant.
        layout = next(
            (each for each in found if each.fits),
            max(found[:3], key=lambda each: len(each.names)),
        )
        comma = layout.separator != "," and _has_commas(lines, layout.separator)
    except csv.Error:
        layout, comma = None, False
    if layout is None or any(map(_NO_TEXT.search, layout.names)):
        raise InputError(
            f"{path}: is not UTF-8 text with a cell for each column; export it as CSV "
            "in UTF-8"
        )
    if not layout.names and layout.lines == len(lines):
        raise InputError(f"{path}: is empty; the first line must name the columns")
    units = map(written_unit, layout.units)
    return TextDialect(
        tuple(layout.names),
        tuple(units) or tuple(split_name(name)[1] for name in layout.names),
        layout.lines,
        layout.separator,
        "," if comma else ".",
    )


def opened_table(path: Path, dialect: TextDialect) -> pa.NativeFile:
    """The file for Arrow, which knows separators of one character only."""
    if dialect.separator != " ":
        # Bytes: as text Arrow takes no name that is not UTF-8.
        return pa.OSFile(os.fsencode(path))
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        text = "\n".join("\t".join(_cells(line)) for line in file)
    return pa.BufferReader(text.encode())


class _Layout:
    """The first lines, as one separator cuts them."""

    def __init__(self, lines: Sequence[str], separator: str) -> None:
        self.separator = separator
        rows = list(_rows(lines, separator))
        first = next((k for k, (_, row) in enumerate(rows) if _begins(row)), 1)
        texts = [k for k in range(min(first, len(rows))) if _is_text(rows[k][1])]
        start = texts[-1] + 1 if texts else min(first, 1, len(rows))
        above = [rows[k][1] for k in texts] or [row for _, row in rows[:start]]
        width = len(rows[start][1]) if start < len(rows) else 0
        if not above and rows:
            comments = (_COMMENT.sub("", each, count=1) for each in lines)
            before = [row for at, row in _rows(comments, separator) if at < rows[0][0]]
            above = [row for row in before if len(row) == width and _is_text(row)]
        self.units = above.pop() if _has_units(above) else []
        names = [name.strip() for name in above.pop()] if above else []
        self.names = _told_apart(names, above)
        self.lines = rows[start][0] if start < len(rows) else len(lines)
        following = rows[start + 1][1] if start + 1 < len(rows) else [""] * width
        self.fits = width > 1 and width == len(names or following)


def _rows(lines: Iterable[str], separator: str) -> Iterator[tuple[int, list[str]]]:
    """Rows, and how many lines stand above each; neither comments nor blank lines."""
    plain = ("\n" if _COMMENT.match(line) else line for line in lines)
    if separator == " ":
        yield from ((k, row) for k, line in enumerate(plain) if (row := _cells(line)))
        return
    reader, above = csv.reader(plain, delimiter=separator), 0
    for row in reader:
        if len(row) > 1 or "".join(row).strip():
            yield above, row
        above = reader.line_num


def _cells(line: str) -> list[str]:
    """What white space cuts, with a date and its time of day in one cell."""
    return _SPACED_DATE.sub(lambda date: date[0].replace(" ", "_"), line).split()


def _has_commas(lines: Iterable[str], separator: str) -> bool:
    """Whether commas stand in numbers, and points do not: these may be thousands."""
    cells = (cell for _, row in _rows(lines, separator) for cell in row)
    return {found[1] for each in cells if (found := _DECIMAL.fullmatch(each))} == {","}


def _begins(row: Sequence[str]) -> bool:
    """Whether its first cell that is not empty is a number, a time or a vector."""
    first = next((cell.strip() for cell in row if cell.strip()), "")
    return bool(_NUMBER.fullmatch(first) or _TIME_OR_VECTOR.fullmatch(first))


def _is_text(row: Sequence[str]) -> bool:
    """Whether it has words, and no numbers."""
    cells = [cell.strip() for cell in row]
    return any(cells) and not any(map(_NUMBER.fullmatch, cells))


def _has_units(above: Sequence[Sequence[str]]) -> bool:
    """Whether the last line is one of units: known ones, or one for several columns."""
    if len(above) < 2 or len(above[-1]) != len(above[-2]):
        return False
    names, units = above[-2:]
    repeated = len(set(units)) < len(units) and len(set(names)) == len(names)
    return repeated or any(map(written_unit, units))


def _told_apart(names: list[str], above: Sequence[Sequence[str]]) -> list[str]:
    """Names of which one is given twice, with what stands above: `Position.X`."""
    for row in reversed(above):
        if len(row) == len(names) and len(set(names)) < len(names):
            pairs = zip((upper.strip() for upper in row), names, strict=True)
            names = [".".join(filter(None, pair)) for pair in pairs]
    return names


def _skip_no_row(row: arrow_csv.InvalidRow) -> str:
    return "skip" if not row.text.strip() or _COMMENT.match(row.text) else "error"


_BLOCK_BYTES = 1 << 20
"""What is parsed at once."""
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
    names = _checked_dialect(path).names
    columns = joined_batches(names, csv_lines(path), csv_batches(path))
    pa.default_memory_pool().release_unused()
    return columns


def joined_batches(
    names: Iterable[str], most: int, batches: Iterable[Mapping[str, np.ndarray]]
) -> dict[str, np.ndarray]:
    """Every column of a table, `t` among them, of which `most` rows may come."""
    columns, start = {name: np.empty(most) for name in names}, 0
    for batch in batches:
        rows = slice(start, start + batch["t"].size)
        for name, values in batch.items():
            columns[name][rows] = values
        start = rows.stop
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
