"""A table as data, shown by the terminal and by reports; the one import of pandas."""

from collections.abc import Iterable, Mapping
from math import floor, isfinite, isnan, log10
from typing import Any, NamedTuple

from orbident.extras import extra


def frame(columns: Mapping[str, Any], index: Any, name: str) -> Any:
    """A `pandas.DataFrame`.

    Raises:
        MissingLibraryError: pandas is not installed.
    """
    with extra("pandas", "to_frame()"):
        import pandas as pd
    return pd.DataFrame(dict(columns), index=pd.Index(index, name=name))


DIGITS = 6
"""The most significant ones, also where the deviation is smaller."""

SMALLEST, LARGEST = -4, 5
"""Powers of ten of a number's first digit beyond which it is written with a power."""

FINEST = -9
"""The power of ten of a number's last digit below which it is written with a power."""


def power_of_ten(value: float) -> int:
    """That of the first digit."""
    return floor(log10(abs(value))) if value else 0


def last_digit(value: float, std: float) -> int:
    """The power of ten of the last digit that says something: two of the deviation."""
    last = power_of_ten(value) - DIGITS + 1
    return max(power_of_ten(std) - 1, last) if isfinite(std) and std else last


def plain(value: float, last: int) -> str:
    """A finite number as plain text, to the power of ten of its last digit."""
    power = power_of_ten(value)
    beyond = power >= last and not SMALLEST <= power <= LARGEST
    if beyond or last < FINEST:
        return f"{value:.{max(power - last, 0)}e}"
    # Without a sign where nothing is left.
    return f"{round(value, -last) + 0.0:.{max(-last, 0)}f}"


class Numeric(NamedTuple):
    """A number in a cell."""

    value: float | None
    """None or NaN where it is not known."""
    form: str = ".3g"
    """How plain text has it. Where it begins with a plus, it is a difference."""
    std: float | None = None
    """The standard deviation of the number, in its unit; digits of the number that are
    smaller are left out."""

    @property
    def is_known(self) -> bool:
        """Whether there is a number to show."""
        return self.value is not None and not isnan(self.value)

    def __str__(self) -> str:
        """Plain text; a dash where it is not known."""
        if self.value is None or isnan(self.value):
            return "-"
        value = float(self.value)
        last = last_digit(value, self.std or 0.0) if isfinite(value) else 0
        if isfinite(value) and last > power_of_ten(value) - DIGITS + 1:
            return plain(value, last)
        # The number is surer than six digits say: all that its form has are shown.
        return f"{self.value:{self.form}}"


class Interval(NamedTuple):
    """The 95 % interval of what is normally distributed."""

    value: float
    std: float

    @property
    def is_known(self) -> bool:
        """Whether there are ends to show."""
        return not (isnan(self.value) or isnan(self.std))

    def __str__(self) -> str:
        """Plain text; a dash where it is not known."""
        # Late, because 'doctor' has tables where NumPy cannot be imported.
        from orbident.gaussian import NINETY_FIVE

        if not self.is_known:
            return "-"
        last, half = last_digit(self.value, self.std), NINETY_FIVE * self.std
        return f"{plain(self.value - half, last)} to {plain(self.value + half, last)}"


Cell = str | Numeric | Interval
"""What stands in a row of a table."""


class TableRow(NamedTuple):
    """One row of a table."""

    cells: tuple[Cell, ...]
    note: str = ""
    """Note in small letters below the row: a formula."""
    marked: bool = False
    """Whether the eye is to find it."""


class DataTable(NamedTuple):
    """Rows of words and numbers, with units in the head or in the rows."""

    title: str
    head: tuple[str, ...]
    rows: tuple[TableRow, ...]
    in_words: bool = False
    """Whether its cells are words more than numbers."""
    folded: bool = False
    """Whether a click opens it."""

    def without_empty_columns(self) -> "DataTable":
        """Only the columns in which something is known."""
        columns = [[row.cells[k] for row in self.rows] for k in range(len(self.head))]
        used = [
            any(c if isinstance(c, str) else c.is_known for c in each)
            for each in columns
        ]
        rows = (row._replace(cells=_where(used, row.cells)) for row in self.rows)
        return self._replace(head=_where(used, self.head), rows=tuple(rows))


def _where(used: list[bool], cells: tuple) -> tuple:
    return tuple(cell for cell, use in zip(cells, used, strict=True) if use)


def table_of(
    title: str,
    head: tuple[str, ...],
    rows: Iterable[tuple[Cell, ...]],
    in_words: bool = False,
) -> DataTable:
    """A table whose rows have neither notes nor marks."""
    return DataTable(title, head, tuple(map(TableRow, rows)), in_words)
