"""A report as one HTML file that needs nothing else, no network either.

What a report is made of: sections of words, tables and charts.

What a report says first: may the result be used, and why.
"""

import base64
import gzip
import json
from collections.abc import Sequence
from functools import lru_cache
from math import isfinite
from typing import Any, NamedTuple

import numpy as np

from orbident.data_table import DataTable
from orbident.estimation.checks import Check, Level
from orbident.estimation.result import Result
from orbident.extras import extra
from orbident.report.charts import numbers
from orbident.report.numbers import interval_text, short, typeset, with_std


class Chart(NamedTuple):
    """A figure in plotly's words, which `drawing` draws too; colours are the page's."""

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
    tables: tuple[DataTable, ...] = ()
    charts: tuple[Chart, ...] = ()
    pictures: tuple[Picture, ...] = ()


HEADLINES: dict[Level, str] = {
    "trust": "Trust it",
    "with care": "Usable, with reservations",
    "do not trust": "Do not trust it",
}


class Verdict(NamedTuple):
    """The head of a report."""

    level: Level
    mass: str
    """The mass in words; empty where there is none."""
    checks: tuple[Check, ...]
    notes: tuple[str, ...]
    """What was done to the recording."""

    @property
    def headline(self) -> str:
        """The level, as an advice."""
        return HEADLINES[self.level]

    @property
    def style(self) -> str:
        """The level, as a style's name."""
        return self.level.replace(" ", "-")


def verdict_of(result: Result) -> Verdict:
    """The checks of a result; this module adds none."""
    return Verdict(result.level, mass_in_words(result), result.checks, result.notes)


def mass_in_words(result: Result) -> str:
    """The mass with its interval."""
    M, std = result.mass.value, result.mass.std
    if not np.isfinite(M):
        return ""
    return f"{with_std(M, std)} ± {short(std, 2)} kg (95 %: {interval_text(M, std)} kg)"


def page(
    title: str, subtitle: str, verdict: Verdict, sections: Sequence[Section]
) -> str:
    """The page.

    Args:
        title: what it is about.
        subtitle: how that came about.
        verdict: what it says first.
        sections: all else.
    """
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("orbident.report", "template"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["typeset"] = typeset
    figures = {
        chart.name: chart.figure for section in sections for chart in section.charts
    }
    return environment.get_template("page.html").render(
        title=title,
        subtitle=subtitle,
        verdict=verdict,
        sections=sections,
        figures=embedded(figures),
        plotly=plotly() if figures else "",
    )


def embedded(data: object) -> str:
    """JSON that ends no script element, whatever names are in it; null for NaN."""
    text = json.dumps(_drawable(data), allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c")


def _drawable(data: object, key: str = "") -> object:
    """The data with gaps, plotly's null, for what is not finite, and packed arrays."""
    if isinstance(data, np.ndarray):
        # Of what is measured nobody sees more digits; times may be large.
        return numbers(data, "<f4" if key in {"y", "z"} else "<f8")
    if isinstance(data, dict):
        return {name: _drawable(value, name) for name, value in data.items()}
    if isinstance(data, list | tuple):
        return [_drawable(value) for value in data]
    return None if isinstance(data, float) and not isfinite(data) else data


@lru_cache(maxsize=1)
def plotly() -> str:
    """plotly.js, packed to two fifths of its size: a page unpacks it when opened.

    Raises:
        MissingLibraryError: plotly is not installed.
    """
    # Late: without it, a RUN is written without its report.
    with extra("report", "the report"):
        from plotly.offline import get_plotlyjs

    return base64.b64encode(gzip.compress(get_plotlyjs().encode(), 6, mtime=0)).decode()
