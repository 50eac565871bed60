"""A report as one HTML file that needs nothing else, no network either.

It says first whether the result may be used, and why. Then come sections of words,
tables and charts. Numbers have as many digits as the deviation leaves, and no more.
"""

import base64
import gzip
import json
import math
from collections.abc import Sequence
from functools import lru_cache
from importlib.resources import files
from typing import Any, NamedTuple, TypeGuard

import numpy as np

from orbident.data_table import (
    Cell,
    DataTable,
    Interval,
    last_digit,
    plain,
    power_of_ten,
)
from orbident.estimation.checks import VERDICTS, Check, Level
from orbident.estimation.result import Result
from orbident.extras import extra
from orbident.gaussian import NINETY_FIVE
from orbident.report.charts import numbers

NONE = "\N{EN DASH}"
"""Instead of what is not known."""

_RAISED = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")


def known(value: float | int | None) -> TypeGuard[float]:
    """Whether it is a number at all."""
    return value is not None and math.isfinite(value)


def with_std(value: float, std: float) -> str:
    """A value with the digits that its deviation leaves."""
    return _to(value, last_digit(value, std)) if known(value) else NONE


def interval_text(value: float, std: float) -> str:
    """The 95 % interval, with the digits of the value."""
    if not (known(value) and known(std)):
        return NONE
    last, half = last_digit(value, std), NINETY_FIVE * std
    return f"{_to(value - half, last)} to {_to(value + half, last)}"


def short(value: float | None, digits: int = 3) -> str:
    """So many significant digits."""
    if value is None or not known(value):
        return NONE
    return _to(value, power_of_ten(value) - digits + 1)


def signed(difference: float) -> str:
    """A difference with its sign, two digits."""
    if not known(difference):
        return NONE
    return ("+" if difference > 0 else "") + short(difference, 2)


def typeset(cell: Cell) -> str:
    """A cell of a table as a report shows it."""
    if isinstance(cell, str):
        return cell.replace(" m^2", " m²")
    if isinstance(cell, Interval):
        return interval_text(cell.value, cell.std)
    if not known(cell.value):
        return NONE
    if cell.std is not None:
        return with_std(cell.value, cell.std)
    if cell.form[0] == "+":
        return signed(cell.value)
    if cell.form[-1] in "fd":
        return f"{cell.value:{cell.form}}".replace("-", "\N{MINUS SIGN}")
    return short(cell.value, int(cell.form[1:-1]))


def _to(value: float, last: int) -> str:
    mantissa, _, exponent = plain(value, last).partition("e")
    power = f"·10{str(int(exponent)).translate(_RAISED)}" if exponent else ""
    return mantissa.replace("-", "\N{MINUS SIGN}") + power


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
    panels: tuple[str, ...] = ()
    """Names of its panels where one can be shown alone, here and in the charts after it
    up to the next `first` one."""


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
        """The level, in a word."""
        return VERDICTS[self.level].capitalize()


def verdict_of(result: Result) -> Verdict:
    """The checks of a result, and its mass with the interval; it adds no check."""
    M, std = result.mass.value, result.mass.std
    mass = f"{with_std(M, std)} ± {short(std, 2)} kg (95 %: {interval_text(M, std)} kg)"
    return Verdict(
        result.level, mass if np.isfinite(M) else "", result.checks, result.notes
    )


def page(
    title: str, subtitle: str, verdict: Verdict, sections: Sequence[Section]
) -> str:
    """The page."""
    figures = {
        chart.name: chart.figure for section in sections for chart in section.charts
    }
    return filled(
        "page.html",
        title=title,
        subtitle=subtitle,
        verdict=verdict,
        sections=sections,
        figures=embedded(figures),
        plotly=plotly() if figures else "",
    )


def filled(template: str, **values: Any) -> str:
    """A template of this package with these values."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("orbident.report", "template"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["typeset"] = typeset
    return environment.get_template(template).render(values)


def report_text(name: str) -> str:
    """A file of this package's `template`."""
    return (files("orbident.report") / "template" / name).read_text("utf-8")


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
    return None if isinstance(data, float) and not math.isfinite(data) else data


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
