"""Tables of text with columns of any names, one a file, or one signal a file."""

from contextlib import ExitStack, suppress
from pathlib import Path

import pyarrow as pa
import pyarrow.csv as arrow_csv

from orbident.errors import InputError
from orbident.files.names import one_line
from orbident.recordings.csv_table import (
    TextDialect,
    csv_lines,
    opened_table,
    text_dialect,
)
from orbident.recordings.logs.arrow_file import fields_of
from orbident.recordings.logs.group import Tree, unusable

SUFFIXES = (".42", ".csv", ".tsv", ".txt", ".dat")
_EMPTY = ["", "nan", "NaN", "NAN", "null"]


def read_text_table(path: Path, stack: ExitStack) -> Tree:
    """Columns by name; those without names are `qbn.0`, `qbn.1` of a file `qbn.42`.

    Raises:
        InputError: the first lines are not UTF-8, a row has another number of cells, or
            a name is given twice.
    """
    del stack
    dialect = text_dialect(path)
    try:
        table = _table(path, dialect, arrow_csv.ParseOptions(delimiter=dialect.mark))
    except pa.ArrowInvalid:
        # Arrow gives no row that is not UTF-8 to what leaves rows out.
        csv_lines(path)
        table = _without_comments(path, dialect)
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


def _without_comments(path: Path, dialect: TextDialect) -> pa.Table:
    try:
        return _table(path, dialect, dialect.parse_options())
    except pa.ArrowInvalid:
        _refuse_uneven(path, dialect)
        raise


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
