"""Pieces of charts: data as plotly takes it, arrays in it, colours by their role.

Of long recordings a picture shows the extremes of every column of pixels.
"""

import base64
import html
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float, Int

MEASURED, PREDICTED, ERROR, BAND = "--measured", "--predicted", "--error", "--band"
LIMIT = "--limit"
PARTS = (
    *(PREDICTED, ERROR, "--yes", LIMIT, "--care", "--positive", "--negative"),
    *("--faint", MEASURED),
)
"""Of what a whole is made of."""

MANY = 40
"""Rows of a chart: they come closer."""

TICKS = 26
"""Names along an axis of cells."""

COLORS = [[0, "--negative"], [0.5, "--card"], [1, "--positive"]]

LONGEST = 40
"""Characters of a name in a chart."""

Trace = dict[str, Any]
Figure = dict[str, Any]


class Panel(NamedTuple):
    """One of several plots above each other."""

    title: str
    traces: Sequence[Trace]
    band: float | None = None
    """Half the height of what is shaded about zero."""
    y: Mapping[str, Any] = MappingProxyType({})
    """More of the vertical axis."""


def label(text: str) -> str:
    """A name as plotly shows it: no markup, not too long."""
    text = " ".join(text.split())
    shown = text if len(text) <= LONGEST else text[: LONGEST - 1] + "…"
    return html.escape(shown, quote=False)


def numbers(x: np.ndarray, kind: str = "<f8") -> dict[str, str]:
    """An array as plotly reads it, in a third of the space that its digits take."""
    raw = np.ascontiguousarray(x, dtype=kind).tobytes()
    shape = {} if x.ndim == 1 else {"shape": ", ".join(map(str, x.shape))}
    return {"dtype": kind[1:], "bdata": base64.b64encode(raw).decode(), **shape}


def line(x: np.ndarray, y: np.ndarray, color: str, **more: Any) -> Trace:
    """A curve through all points."""
    return _scatter("lines", x, y, {"line": {"color": color, "width": 1.2}}, more)


def history(t: np.ndarray, x: np.ndarray, color: str, **more: Any) -> Trace:
    """A curve of many samples."""
    shown = extremes(t, x)
    return line(*with_gaps(t[shown], x[shown]), color, **more)


def points(x: np.ndarray, y: np.ndarray, color: str, **more: Any) -> Trace:
    """A dot a point."""
    return _scatter("markers", x, y, {"marker": {"color": color, "size": 4}}, more)


def bars(x: Any, y: Any, color: str) -> Trace:
    """A bar a number."""
    marker = {"color": color}
    return {"type": "bar", "x": x, "y": y, "marker": marker, "showlegend": False}


def _scatter(
    mode: str,
    x: np.ndarray,
    y: np.ndarray | list[int],
    style: Mapping[str, Any],
    more: Mapping[str, Any],
) -> Trace:
    legend = {"showlegend": "name" in more}
    return {"type": "scatter", "mode": mode, "x": x, "y": y, **style, **legend, **more}


def stacked(panels: Sequence[Panel], x_title: str, **x: Any) -> Figure:
    """Panels above each other, with one horizontal axis."""
    height, between = 110, 34
    whole = len(panels) * (height + between)
    data, annotations, shapes = [], [], []
    named = any(trace["showlegend"] for panel in panels for trace in panel.traces)
    above, below = (28 if named else 0), 44
    layout: Figure = {
        "height": whole + above + below,
        "margin": {"t": above, "b": below},
    }
    for k, panel in enumerate(panels):
        top = 1 - k * (height + between) / whole - between / whole
        axis = "" if k == 0 else str(k + 1)
        bottom = max(top - height / whole, 0.0)
        layout[f"yaxis{axis}"] = {"domain": [bottom, top], "nticks": 5, **panel.y}
        data += [{**trace, "yaxis": f"y{axis}"} for trace in panel.traces]
        annotations.append(_heading(panel.title, top))
        if panel.band:
            shapes.append(_band(panel.band, f"y{axis}"))
    last = "" if len(panels) == 1 else str(len(panels))
    layout["xaxis"] = {"anchor": f"y{last}", "title": {"text": x_title}, **x}
    return {
        "data": data,
        "layout": {**layout, "annotations": annotations, "shapes": shapes},
    }


def decades(*values: np.ndarray) -> dict[str, Any]:
    """A logarithmic axis whose ends are powers of ten."""
    positive = [x[x > 0] for x in values]
    ends = np.log10([(x.min(), x.max()) for x in positive if x.size] or [(1.0, 1.0)])
    low, high = int(np.floor(ends.min())), int(np.ceil(ends.max()))
    return {
        "type": "log",
        "range": [low, max(high, low + 1)],
        "dtick": max(1, -(-(high - low) // 4)),
        "exponentformat": "power",
    }


def _heading(text: str, top: float) -> Figure:
    return {
        "text": label(text),
        "xref": "paper",
        "yref": "paper",
        "x": 0,
        "y": top,
        "xanchor": "left",
        "yanchor": "bottom",
        "showarrow": False,
    }


def _band(half: float, axis: str) -> Figure:
    return {
        "type": "rect",
        "xref": "paper",
        "yref": axis,
        "x0": 0,
        "x1": 1,
        "y0": -half,
        "y1": half,
        "fillcolor": BAND,
        "line": {"width": 0},
        "layer": "below",
    }


def interval_list(
    names: Sequence[str],
    x: np.ndarray,
    half: np.ndarray,
    zero: float,
    least: float,
    x_title: str,
    words: Sequence[str],
) -> Figure:
    """Intervals, one below the other, with a line at what is expected.

    Around the estimates `x` are `half` of their intervals; `zero` is what is expected.
    The axis reaches `least` from it at least: rounding is not to fill a chart. A row
    says its words under a mouse.
    """
    ends = np.array([-0.5, len(names) - 0.5])
    upright = line(np.full(2, zero), ends, LIMIT, hoverinfo="skip")
    reach = float(np.max(np.abs(x - zero) + half, initial=0.0))
    ends = {"range": [zero - least, zero + least]} if reach < least else {}
    style = {
        "error_x": {"array": half, "color": PREDICTED, "thickness": 1.5},
        "marker": {"color": PREDICTED, "size": 7},
        "hovertext": ["<br>".join(map(label, text.split("\n"))) for text in words],
        "hoverinfo": "text",
    }
    intervals = _scatter("markers", x, list(range(len(x))), style, {})
    layout = _list_of(names, x_title, **ends)
    # A row answers wherever the mouse is in it.
    layout["hovermode"] = "y"
    return {"data": [upright, intervals], "layout": layout}


def _list_of(names: Sequence[str], x_title: str, **x: Any) -> Figure:
    return {
        "height": (24 if len(names) < MANY else 13) * len(names) + 80,
        "margin": {"t": 8, "b": 44},
        "xaxis": {"title": {"text": x_title}, "nticks": 5, "tickangle": 0, **x},
        "yaxis": {
            # Numbered: shortened names may be alike.
            "tickvals": list(range(len(names))),
            "ticktext": [label(name) for name in names],
            "range": [len(names) - 0.5, -0.5],
            "automargin": True,
        },
    }


def shares_across(
    names: Sequence[str],
    shares: Mapping[str, Float[np.ndarray, " names"]],
    x_title: str,
) -> Figure:
    """Bars, one below the other, each made of parts of several colours.

    The parts begin on the left.
    """
    ends = np.cumsum([*shares.values()], axis=0)
    rows = list(range(len(names)))
    data = [
        {
            "type": "bar",
            "orientation": "h",
            "x": x,
            "y": rows,
            "base": end - x,
            "name": label(name),
            "marker": {"color": PARTS[k % len(PARTS)]},
            "showlegend": True,
        }
        for k, ((name, x), end) in enumerate(zip(shares.items(), ends, strict=True))
    ]
    layout = _list_of(names, x_title, range=[0, float(ends[-1].max())])
    layout["barmode"] = "overlay"
    layout["margin"]["t"] = 28 * -(-len(shares) // 4)
    return {"data": data, "layout": layout}


def heat_map(
    down: Sequence[str],
    across: Sequence[str],
    z: Float[np.ndarray, "down across"],
    full: float,
    height: int,
    **more: Any,
) -> Figure:
    """A coloured cell a number, those above zero red, those below blue.

    A colour is full at the size `full`; the height is in pixels, and `more` is of the
    trace.
    """
    trace = {
        "type": "heatmap",
        "z": z,
        "zmin": -full,
        "zmax": full,
        "colorscale": COLORS,
        "showlegend": False,
        **more,
    }
    layout = {
        "height": height,
        "margin": {"t": 12, "b": 64},
        "xaxis": {**_names(across), "tickangle": -90},
        "yaxis": {**_names(down), "autorange": "reversed"},
    }
    return {"data": [trace], "layout": layout}


def _names(names: Sequence[str]) -> Figure:
    step = -(-len(names) // TICKS)
    return {
        # Numbered: shortened names may be alike.
        "tickvals": list(range(0, len(names), step)),
        "ticktext": [label(name) for name in names[::step]],
        "showgrid": False,
        "automargin": True,
    }


COLUMNS = 600
"""Columns of pixels of a chart: as wide as two of them are on a page."""

GAP = 5.0
"""Times the usual distance of samples: no line is drawn across,"""

WIDE = 0.01
"""nor anywhere but where it is this part of the whole."""


def extremes(
    t: Float[np.ndarray, " n"], x: Float[np.ndarray, " n"], columns: int = COLUMNS
) -> Int[np.ndarray, " shown"]:
    """Which samples to draw: least and largest of each column, in order.

    Times increase, values are finite, and columns are those of pixels.
    """
    if t.size <= 2 * columns:
        return np.arange(t.size)
    span = t[-1] - t[0]
    column = np.minimum((t - t[0]) / span * columns, columns - 1).astype(int)
    starts = np.flatnonzero(np.diff(column, prepend=-1))
    counts = np.diff(starts, append=t.size)
    chosen = [
        _first_of_each(x == np.repeat(extreme.reduceat(x, starts), counts), column)
        for extreme in (np.minimum, np.maximum)
    ]
    return np.union1d(*chosen)


def _first_of_each(hit: np.ndarray, column: np.ndarray) -> Int[np.ndarray, " columns"]:
    hits = np.flatnonzero(hit)
    _, first = np.unique(column[hits], return_index=True)
    return hits[first]


def with_gaps(
    t: Float[np.ndarray, " n"], x: Float[np.ndarray, " n"]
) -> tuple[Float[np.ndarray, " m"], Float[np.ndarray, " m"]]:
    """The samples with a NaN wherever a sensor was silent for long."""
    dt = np.diff(t)
    if not dt.size:
        return t, x
    wide = max(GAP * float(np.median(dt)), WIDE * float(t[-1] - t[0]))
    after = np.flatnonzero(dt > wide) + 1
    return np.insert(t, after, t[after]), np.insert(x, after, np.nan)
