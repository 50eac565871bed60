"""Charts of a campaign: histograms, normal plots, what errors depend on."""

import numpy as np
from jaxtyping import Float
from scipy import stats

from orbident.campaigns.statistics import Dependence
from orbident.report.charts import (
    LIMIT,
    MEASURED,
    PREDICTED,
    Figure,
    Panel,
    Trace,
    line,
    numbers,
    stacked,
)

REACH = 4.0
"""Deviations that a histogram shows; what is beyond counts in its ends."""

BARS = 32
POINTS = 400
"""Points of a normal plot or a scatter: more would not be seen."""


def histogram(z: Float[np.ndarray, " n"]) -> Figure:
    """Errors over deviations, beside the normal density."""
    edges = np.linspace(-REACH, REACH, BARS + 1)
    count, _ = np.histogram(np.clip(z, -REACH, REACH), edges)
    width = edges[1] - edges[0]
    middle = (edges[1:] + edges[:-1]) / 2
    bars = {
        "type": "bar",
        "x": numbers(middle),
        "y": numbers(count / (z.size * width), "<f4"),
        "marker": {"color": MEASURED},
        "showlegend": False,
    }
    x = np.linspace(-REACH, REACH, 100)
    normal = line(x, stats.norm.pdf(x), PREDICTED)
    return stacked([Panel("density", [bars, normal])], "error / deviation", nticks=9)


def normal_plot(z: Float[np.ndarray, " n"]) -> Figure:
    """Quantiles of errors over deviations against those of the normal distribution."""
    p = (np.arange(z.size) + 0.5) / z.size
    shown = _some(z.size)
    x = stats.norm.ppf(p)[shown]
    ends = np.array([x[0], x[-1]])
    points = _points(x, np.sort(z)[shown])
    panel = Panel("error / deviation", [line(ends, ends, LIMIT), points])
    return stacked([panel], "normal quantile")


def dependence(each: Dependence) -> Figure:
    """A scatter of an error over what was drawn."""
    shown = _some(each.x.size)
    words = "size of error / deviation" if each.of_size else "error / deviation"
    panel = Panel(words, [_points(each.x[shown], each.y[shown])])
    return stacked([panel], each.draw)


def _some(n: int) -> np.ndarray:
    """Evenly chosen, the first and the last among them."""
    return np.unique(np.linspace(0, n - 1, min(n, POINTS)).round().astype(int))


def _points(x: np.ndarray, y: np.ndarray) -> Trace:
    return {
        "type": "scatter",
        "mode": "markers",
        "x": numbers(x),
        "y": numbers(y, "<f4"),
        "marker": {"color": MEASURED, "size": 4},
        "showlegend": False,
    }
