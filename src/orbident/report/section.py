"""What a report is made of: sections of words, tables and charts."""

import base64
from typing import Any, NamedTuple


class TableRow(NamedTuple):
    """One row of a table."""

    cells: tuple[str, ...]
    note: str = ""
    """Note in small letters below the row: a formula."""
    marked: bool = False
    """Whether the eye is to find it."""


class ReportTable(NamedTuple):
    """A table of numbers, with units in its head."""

    title: str
    head: tuple[str, ...]
    rows: tuple[TableRow, ...]
    in_words: bool = False
    """Whether its cells are words more than numbers."""
    folded: bool = False
    """Whether a click opens it."""


class Chart(NamedTuple):
    """A plotly figure as plain data; a colour may be the name of one of the page's."""

    name: str
    """Unique in a report."""
    title: str
    figure: dict[str, Any]
    first: bool = False
    """Whether it begins a line of the page."""
    wide: bool = False
    """Whether it takes a whole line; on a narrow screen it is scrolled."""


class Picture(NamedTuple):
    """A drawing that is kept as a file too."""

    title: str
    svg: str

    @property
    def source(self) -> str:
        """The drawing inside the page, where its styles and names touch no other's."""
        packed = base64.b64encode(self.svg.encode()).decode()
        return f"data:image/svg+xml;base64,{packed}"


class Section(NamedTuple):
    """A heading and what stands below it."""

    name: str
    """Unique in a report."""
    title: str
    words: tuple[str, ...] = ()
    tables: tuple[ReportTable, ...] = ()
    charts: tuple[Chart, ...] = ()
    pictures: tuple[Picture, ...] = ()
