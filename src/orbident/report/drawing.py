"""Charts of a report as drawings of matplotlib; its and Pillow's one import."""

import html
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO, StringIO
from pathlib import Path
from typing import Any

import numpy as np

from orbident.errors import InputError
from orbident.estimation.result import Result
from orbident.estimation.signals import Signals
from orbident.extras import extra
from orbident.files.replacing import replacing, write_text
from orbident.report.charts import Trace
from orbident.report.conditioning import conditioning
from orbident.report.convergence_section import convergence
from orbident.report.fit import charts_of
from orbident.report.page import Chart, Picture, Section, report_text
from orbident.report.parameter_section import (
    masses,
    parameters,
    sensitivities,
    variance_shares,
)

with extra("report", "drawing a figure"):
    from matplotlib import rc_context
    from matplotlib.axes import Axes
    from matplotlib.collections import PolyCollection
    from matplotlib.figure import Figure, SubFigure
    from matplotlib.ticker import MultipleLocator
    from PIL import Image

__all__ = ["Drawing", "Image", "PolyCollection", "drawn", "kept"]

PIXELS = 90.0
"""Pixels of a chart an inch of a drawing."""

WIDTH = {1: 7.0, 2: 9.0, 3: 12.0}
"""Inches, by the number of charts beside each other."""

DARK = 0.65
"""The part of a full colour from which on numbers in it are white."""


class Drawing(Figure):
    """A figure that belongs to no window; a notebook shows it."""

    def _repr_png_(self) -> bytes:
        picture = BytesIO()
        self.savefig(picture, format="png")
        return picture.getvalue()


def drawn(rows: Sequence[Sequence[Chart]]) -> Drawing:
    """Charts of a report as one drawing, row by row."""
    heights = [max(c.figure["layout"]["height"] for c in row) / PIXELS for row in rows]
    size = WIDTH[len(rows[0])], sum(heights) + 0.35 * len(rows)
    drawing = Drawing(figsize=size, layout="constrained")
    shape = len(rows), len(rows[0])
    parts = drawing.subfigures(*shape, squeeze=False, height_ratios=heights)
    for charts, beside in zip(rows, parts, strict=True):
        for chart, part in zip(charts, beside, strict=True):
            part.suptitle(chart.title, fontsize=10)
            _draw(chart.figure, part)
    return drawing


def _draw(figure: Mapping[str, Any], part: SubFigure) -> None:
    layout, colors = figure["layout"], _colors()
    names = [key for key in layout if key.startswith("yaxis")]
    grid = part.subplots(len(names), sharex=True, squeeze=False)[:, 0]
    panels: dict[str, Axes] = dict(zip(names, grid, strict=True))
    for trace in figure["data"]:
        _trace(panels[f"yaxis{trace.get('yaxis', 'y')[1:]}"], trace, colors)
    for shape in layout.get("shapes", ()):
        axes = panels[f"yaxis{shape['yref'][1:]}"]
        color = colors[shape["fillcolor"]]
        axes.axhspan(shape["y0"], shape["y1"], color=color, linewidth=0, zorder=0)
    headings = [each["text"] for each in layout.get("annotations", ())]
    for axes, text in zip(grid, headings or [""] * len(grid), strict=True):
        axes.set_title(html.unescape(text), loc="left", fontsize=9)
        if layout["xaxis"].get("showgrid", True):
            axes.grid(color="0.9")
        axes.set_axisbelow(True)
        _scale(axes, "x", layout["xaxis"])
    for name, axes in panels.items():
        _scale(axes, "y", layout[name])
    grid[-1].set_xlabel(layout["xaxis"].get("title", {}).get("text", ""))
    curves = [curve for axes in grid for curve in axes.get_legend_handles_labels()[0]]
    if curves:
        below = {"loc": "outside lower center", "ncols": 2, "frameon": False}
        part.legend(handles=curves, fontsize=8, **below)


def _trace(axes: Axes, trace: Trace, colors: Mapping[str, Any]) -> None:
    if trace["type"] == "heatmap":
        _cells(axes, trace)
        return
    x, y, name = trace["x"], trace["y"], trace.get("name")
    style = trace.get("line", trace.get("marker", {}))
    color = colors[trace.get("fillcolor") or style["color"]]
    if trace.get("orientation") == "h":
        axes.barh(y, x, left=trace["base"], color=color, label=name)
    elif trace["type"] == "bar":
        axes.bar(x, y, color=color)
    elif "fill" in trace:
        axes.fill(x, y, color=color, linewidth=0)
    elif "error_x" in trace:
        half = trace["error_x"]["array"]
        axes.errorbar(x, y, xerr=half, fmt="o", markersize=4, color=color)
    else:
        dashed = "--" if "dash" in style else "-"
        axes.plot(
            *(x, y),
            color=color,
            label=name,
            linestyle=dashed if "lines" in trace["mode"] else "",
            linewidth=0.8 * style.get("width", 0.0),
            marker="o" if "markers" in trace["mode"] else "",
            markersize=4,
        )


def _cells(axes: Axes, trace: Trace) -> None:
    z, full = trace["z"], trace["zmax"]
    image = axes.imshow(z, cmap="RdBu_r", aspect="auto", vmin=-full, vmax=full)
    if trace.get("showscale", True):
        axes.figure.colorbar(image, ax=axes, shrink=0.8)
    for (i, k), text in np.ndenumerate(np.array(trace.get("text", [[]]))):
        color = "white" if abs(z[i, k]) > DARK * full else "black"
        axes.text(k, i, text, color=color, ha="center", va="center", fontsize=7)


def _scale(axes: Axes, way: str, given: Mapping[str, Any]) -> None:
    """One axis, "x" or "y", as plotly would have it."""
    logarithmic = given.get("type") == "log"
    if logarithmic:
        axes.set(**{f"{way}scale": "log"})
    elif "dtick" in given:
        axes.xaxis.set_major_locator(MultipleLocator(given["dtick"]))
    if "tickvals" in given:
        names = [html.unescape(name) for name in given["ticktext"]]
        axis = axes.xaxis if way == "x" else axes.yaxis
        turned = -given.get("tickangle", 0)
        axis.set_ticks(given["tickvals"], names, rotation=turned, fontsize=8)
    if "range" in given:
        ends = np.array(given["range"], dtype=float)
        axes.set(**{f"{way}lim": 10.0**ends if logarithmic else ends})


def _colors() -> dict[str, Any]:
    """The page's colours on white paper, by their roles."""
    style = report_text("page.css")
    found = dict(re.findall(r"(--\w+): ([^;]+);", style.partition("}")[0]))
    return {
        role: color
        if color.startswith("#")
        else tuple(
            float(part) / (255 if k < 3 else 1)
            for k, part in enumerate(re.findall(r"[\d.]+", color))
        )
        for role, color in found.items()
    }


def kept(drawing: Drawing, path: Path, title: str) -> Picture:
    """The drawing as a PNG and an SVG file, and for a report.

    The path is without a suffix.

    Raises:
        InputError: nothing can be written there.
    """
    with replacing(path.with_suffix(".png")) as target:
        drawing.savefig(target, format="png", dpi=150)
    # Without a date and with a fixed salt the same data give the same file.
    svg = StringIO()
    with rc_context({"svg.hashsalt": path.name}):
        drawing.savefig(svg, format="svg", metadata={"Date": None})
    write_text(path.with_suffix(".svg"), svg.getvalue())
    return Picture(title, svg.getvalue())


@dataclass(frozen=True, repr=False)
class Plots:
    """The figures of a result; each method draws one, as a `matplotlib` figure.

    A notebook shows it; `figure.savefig("mass.png")` keeps it.
    """

    result: Result

    def __repr__(self) -> str:
        """What can be drawn."""
        names = "signals(), residuals(), parameters(), mass(), budget(), "
        names += "correlations(), sensitivity(), convergence()"
        return f"figures of {self.result.robot.name}: {names}"

    def signals(self) -> Drawing:
        """What was measured and what is predicted; a panel an axis.

        Raises:
            InputError: the result has no signals.
        """
        signals = self._signals()
        # Of an attitude only the difference is known.
        shown = [signal for signal in signals if signal.sensor != "attitude"] or signals
        return drawn([[next(charts_of(signal))] for signal in shown])

    def residuals(self) -> Drawing:
        """Residuals over time, their spectrum, and their autocorrelation.

        Bands are 95 % of the noise found; of white noise 95 % of the autocorrelation
        lies in its band, and the line in a spectrum is that of white noise.

        Raises:
            InputError: the result has no signals.
        """
        return drawn([list(charts_of(signal))[-3:] for signal in self._signals()])

    def parameters(self) -> Drawing:
        """How far the base parameters are from CAD, with 95 % intervals.

        Those of which CAD says zero, or nearly so, have no percentage.

        Raises:
            InputError: the result is rejected.
        """
        self.result.check_accepted()
        return self._of(parameters(self.result, "CAD"), "no parameter has a percentage")

    def mass(self) -> Drawing:
        """The mass by every route, with 95 % intervals; the line is CAD.

        Raises:
            InputError: the result is rejected, or no route gives a mass.
        """
        self.result.check_accepted()
        return self._of(
            masses(self.result, "CAD"),
            "no route gives a mass, so there is nothing to draw; see result.mass_forms",
        )

    def budget(self) -> Drawing:
        """What the variance of each base parameter is made of, in percent.

        Raises:
            InputError: the result has no budget.
        """
        return self._of(
            variance_shares(self.result),
            "what its deviations are made of is not known: only maximum likelihood "
            "computes it, where the result is accepted and something is noisy",
        )

    def correlations(self) -> Drawing:
        """Correlations of the base parameters.

        Raises:
            InputError: no parameter is determined.
        """
        return self._of(
            conditioning(self.result),
            "no base parameter has a deviation, so there are no correlations to draw",
        )

    def sensitivity(self) -> Drawing:
        """By how many of its deviations an instrument's error would shift a parameter.

        Red is upwards, blue downwards; the number is the size.

        Raises:
            InputError: the result has no sensitivity.
        """
        return self._of(
            sensitivities(self.result),
            "what errors of instruments would shift is not known: only maximum "
            "likelihood computes it, where the result is accepted and some instrument "
            "has no tolerance",
        )

    def convergence(self) -> Drawing:
        """Cost and size of the steps of the search, over their number.

        Each curve is a round: after it the noise and the weights of outliers are
        estimated anew. The search ends below the line.

        Raises:
            InputError: the method does not search, or the result was kept by an
                earlier version.
        """
        return self._of(
            convergence(self.result.convergence),
            f"{self.result.method} has no steps to draw; maximum-likelihood and "
            "structured have",
        )

    def _of(self, section: Section | None, missing: str) -> Drawing:
        """The section's charts beside each other; refused where there are none."""
        if section is None or not section.charts:
            raise InputError(f"{self.result.robot.name}: {missing}")
        return drawn([section.charts])

    def _signals(self) -> Signals:
        signals = self.result.signals()
        if not signals:
            raise InputError(
                f"{self.result.robot.name}: nothing was predicted, so there is nothing "
                "to draw; see result.warnings"
            )
        return signals
