"""A report as one HTML file that needs nothing else, no network either."""

import base64
import gzip
import json
from collections.abc import Sequence
from functools import lru_cache
from math import isfinite

from orbident.extras import extra
from orbident.report.section import Section
from orbident.report.verdict import Verdict


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


def _drawable(data: object) -> object:
    """The data with gaps, plotly's null, for what is not finite."""
    if isinstance(data, dict):
        return {key: _drawable(value) for key, value in data.items()}
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
