"""Plots over time with a line where the page is."""

import html
from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Float

MOST_POINTS = 400
"""Most points of a curve: the panel is not wider."""
COLOURS = ("#ee6677", "#228833", "#4477aa", "#aa3377", "#ccbb44", "#66ccee")
NOW = "#222222"


class Plot:
    """Some curves, predicted ones dashed, and the present time."""

    def __init__(
        self,
        server: Any,
        title: str,
        t: Float[np.ndarray, " n"],
        curves: Float[np.ndarray, "n k"],
        names: Sequence[str],
        dashed: Float[np.ndarray, "n k"] | None = None,
    ):
        """Draw it below what is in the panel.

        Args:
            server: viser's.
            title: with the unit.
            t: times, s.
            curves: one a column.
            names: of the curves.
            dashed: the same, predicted.
        """
        columns = curves if dashed is None else np.hstack([curves, dashed])
        chosen = np.arange(0, t.size, -(-t.size // MOST_POINTS))
        self._t = t[chosen]
        self._columns = [np.array(column) for column in columns[chosen].T]
        looks = [{"stroke": _colour(k), "width": 1.5} for k in range(len(names))]
        faint = [{**look, "dash": (6, 4)} for look in looks]
        series = [{}, *looks, *(faint if dashed is not None else ()), {"stroke": NOW}]
        low, high = float(np.nanmin(columns)), float(np.nanmax(columns))
        room = 0.05 * (high - low) or 1.0
        self._ends = low - room, high + room
        words = "dashed: predicted" if dashed is not None else ""
        server.gui.add_html(_caption(title, names, words))
        self._handle = server.gui.add_uplot(
            self._data(0),
            tuple(series),
            scales={"x": {"time": False}, "y": {"range": self._ends}},
            legend={"show": False},
            height=150,
            padding=(10, 16, 0, 0),
        )

    def place(self, t: float) -> None:
        """Move the line there, s."""
        self._handle.data = self._data(int(np.searchsorted(self._t, t)))

    def _data(self, k: int) -> tuple[Float[np.ndarray, " n"], ...]:
        # From the lower end at one sample to the upper one at the next: upright, but
        # for the width of a pixel.
        now = np.full(self._t.size, np.nan)
        k = min(k, self._t.size - 2)
        now[k : k + 2] = self._ends
        return (self._t, *self._columns, now)


def _colour(k: int) -> str:
    return COLOURS[k % len(COLOURS)]


def _caption(title: str, names: Sequence[str], words: str) -> str:
    listed = " ".join(
        f'<span style="color:{_colour(k)}">{html.escape(name)}</span>'
        for k, name in enumerate(names)
    )
    return (
        '<div style="font-size:0.8em;padding:0 1em;overflow-wrap:anywhere">'
        f"<b>{html.escape(title)}</b> {listed} {words}</div>"
    )
