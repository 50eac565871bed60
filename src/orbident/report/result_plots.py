"""The charts of a report as figures of matplotlib, for notebooks and papers."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.estimation.result import Result
from orbident.estimation.signals import Signals
from orbident.estimation.solution import SMALL
from orbident.gaussian import NINETY_FIVE
from orbident.report.charts import extremes, shortened, with_gaps
from orbident.report.conditioning import correlations
from orbident.report.convergence_section import COST, SIZE, is_wide, rounds, spacing
from orbident.report.drawing import Axes, Drawing
from orbident.report.fit import autocorrelation, axis_labels, residuals, spectrum
from orbident.report.parameter_section import differences, surest_routes
from orbident.report.sensitivity_figure import largest_shifts

COLORS = ("#4477aa", "#ee6677", "#228833", "#ccbb44", "#66ccee", "#aa3377", "#bbbbbb")
"""Told apart by the colour-blind too (Tol 2021, bright)."""

ROW, WIDTH = 2.4, 11.0
"""Height of a row of panels, and width of a figure, inches."""

LINE = 0.26
"""Height of a line of text, inches."""

DARK = 0.65
"""The part of a full colour from which on numbers in it are white."""

MOST_ACROSS = 7
"""Names of curves beside each other."""


@dataclass(frozen=True, repr=False)
class Plots:
    """The figures of a result; each method draws one, as a `matplotlib` figure.

    A notebook shows it; `figure.savefig("mass.png")` keeps it.
    """

    result: Result

    def __repr__(self) -> str:
        """What can be drawn."""
        names = "signals(), residuals(), parameters(), mass(), correlations(), "
        names += "sensitivity(), convergence()"
        return f"figures of {self.result.robot.name}: {names}"

    def signals(self) -> Drawing:
        """What was measured, thick, and what is predicted, thin; a panel a signal.

        Raises:
            InputError: the result has no signals.
        """
        signals = self._signals()
        # Of an attitude only the difference is known.
        shown = [signal for signal in signals if signal.sensor != "attitude"] or signals
        drawing, panels = _panels(len(shown), 1)
        for signal, (axes,) in zip(shown, panels, strict=True):
            for k, label in enumerate(axis_labels(signal)):
                color = COLORS[k % len(COLORS)]
                for x, width, alpha in (
                    (signal.measured[:, k], 3.0, 0.35),
                    (signal.predicted[:, k], 0.9, 1.0),
                ):
                    name = label if width < 1 else None
                    axes.plot(
                        *_history(signal.t, x),
                        color=color,
                        linewidth=width,
                        alpha=alpha,
                        label=name,
                    )
            _finish(axes, "t (s)", _unit(signal.units))
            axes.set_title(f"{signal.name}: measured (thick), predicted", loc="left")
        return drawing

    def residuals(self) -> Drawing:
        """Residuals over time, their spectrum, and their autocorrelation.

        Bands are 95 % of the noise found; of white noise 95 % of the autocorrelation
        lies in its band.

        Raises:
            InputError: the result has no signals.
        """
        signals = self._signals()
        drawing, panels = _panels(len(signals), 3)
        for signal, (over_time, over_f, over_lags) in zip(signals, panels, strict=True):
            errors, unit = residuals(signal), _unit(signal.units)
            for k, label in enumerate(signal.axes):
                e, color = errors[:, k], COLORS[k % len(COLORS)]
                over_time.plot(*_history(signal.t, e), color=color, lw=0.9)
                over_f.loglog(*spectrum(signal.t, e), color=color, lw=0.9)
                r = autocorrelation(e)
                lags = np.arange(1, r.size + 1)
                over_lags.plot(lags, r, color=color, lw=0.9, label=label)
            half = NINETY_FIVE * signal.std
            over_time.axhspan(-half, half, color="0.92", zorder=0)
            white = NINETY_FIVE / np.sqrt(signal.t.size)
            over_lags.axhspan(-white, white, color="0.92", zorder=0)
            level = signal.std * np.sqrt(2 * np.median(np.diff(signal.t)))
            over_f.axhline(level, color="0.4", linewidth=0.8, linestyle="--")
            _finish(over_time, "t (s)", f"residual ({unit})")
            _finish(over_f, "f (Hz)", f"{unit}/√Hz")
            _finish(over_lags, "lag (samples)", "autocorrelation")
            over_time.set_title(signal.name, loc="left")
            over_f.set_title("spectrum; dashed: white", loc="left")
            low, high = over_f.get_ylim()
            over_f.set_ylim(
                10 ** np.floor(np.log10(low)), 10 ** np.ceil(np.log10(high))
            )
        return drawing

    def parameters(self) -> Drawing:
        """How far the base parameters are from CAD, with 95 % intervals.

        Those of which CAD says zero, or nearly so, have no percentage.

        Raises:
            InputError: the result is rejected.
        """
        self.result.check_accepted()
        names, off, half = differences(self.result.base)
        return _intervals(names, off, half, 0.0, "difference from CAD (%)")

    def mass(self) -> Drawing:
        """The mass by every route, with 95 % intervals; the line is CAD.

        Raises:
            InputError: the result is rejected, or no route gives a mass.
        """
        self.result.check_accepted()
        routes = self.result.mass_forms
        shown = surest_routes(routes)
        if not shown:
            raise InputError(
                f"{self.result.robot.name}: no route gives a mass, so there is nothing "
                "to draw; see result.mass_forms"
            )
        names = [shortened(routes.names[k]) for k in shown]
        half, M = NINETY_FIVE * routes.std[shown], float(self.result.base.nominal[0])
        return _intervals(names, routes.values[shown], half, M, "M (kg)")

    def correlations(self) -> Drawing:
        """Correlations of the base parameters.

        Raises:
            InputError: no parameter is determined.
        """
        names, R = correlations(self.result)
        if not names:
            raise InputError(
                f"{self.result.robot.name}: no base parameter has a deviation, so "
                "there are no correlations to draw"
            )
        side = 2.5 + LINE * len(names)
        drawing = Drawing(figsize=(side + 1.0, side), layout="constrained")
        axes = drawing.subplots()
        image = axes.imshow(R, cmap="RdBu_r", vmin=-1, vmax=1)
        drawing.colorbar(image, label="correlation", shrink=0.8)
        _name_cells(axes, names, names)
        return drawing

    def sensitivity(self) -> Drawing:
        """By how many of its deviations an instrument's error would shift a parameter.

        Red is upwards, blue downwards; the number is the size.

        Raises:
            InputError: the result has no sensitivity.
        """
        table = self.result.sensitivity()
        if table is None or not np.isfinite(table.shifts).any():
            raise InputError(
                f"{self.result.robot.name}: what errors of instruments would shift is "
                "not known: only maximum likelihood computes it, where the result is "
                "accepted and some instrument has no tolerance"
            )
        shown = largest_shifts(table)
        size = 4.0 + 0.42 * len(shown.parameters), 1.2 + LINE * len(shown.errors)
        drawing = Drawing(figsize=size, layout="constrained")
        axes = drawing.subplots()
        full = shown.full
        axes.imshow(shown.colour, cmap="RdBu_r", aspect="auto", vmin=-full, vmax=full)
        for i, row in enumerate(shown.cells):
            for k, text in enumerate(row):
                dark = abs(shown.colour[i, k]) > DARK * full
                color = "white" if dark else "black"
                axes.text(k, i, text, color=color, ha="center", va="center", fontsize=7)
        _name_cells(axes, shown.parameters, [shortened(name) for name in shown.errors])
        axes.set_title("shift, in each parameter's own standard deviations")
        return drawing

    def convergence(self) -> Drawing:
        """Cost and size of the steps of the search, over their number.

        Each curve is a round: after it the noise and the weights of outliers are
        estimated anew. The search ends below the dashed line.

        Raises:
            InputError: the method does not search, or the result was kept by an
                earlier version.
        """
        steps = self.result.convergence
        if not steps:
            raise InputError(
                f"{self.result.robot.name}: {self.result.method} has no steps to draw; "
                "maximum-likelihood and structured have"
            )
        drawing, panels = _panels(1, 2)
        cost, size = panels[0]
        every = rounds(steps)
        for number, costs, sizes in every:
            cost.plot(number, costs, "o-", color=COLORS[0], markersize=4)
            size.semilogy(number, sizes, "o-", color=COLORS[0], markersize=4)
        if is_wide(every):
            cost.set_yscale("log")
        size.axhline(SMALL, color="0.4", linewidth=0.8, linestyle="--")
        for axes, title in ((cost, COST), (size, SIZE)):
            axes.set_title(title, loc="left")
            taken = int(every[-1].number[-1])
            axes.set_xticks(np.arange(0, taken + 1, spacing(taken)))
            axes.set_xlim(-0.5, taken + 0.5)
            _finish(axes, "step", "")
        return drawing

    def _signals(self) -> Signals:
        signals = self.result.signals()
        if not signals:
            raise InputError(
                f"{self.result.robot.name}: nothing was predicted, so there is nothing "
                "to draw; see result.warnings"
            )
        return signals


def _panels(rows: int, columns: int) -> tuple[Drawing, np.ndarray]:
    drawing = Drawing(figsize=(WIDTH, ROW * rows + 0.4), layout="constrained")
    return drawing, drawing.subplots(rows, columns, squeeze=False)


def _intervals(
    names: Sequence[str],
    x: Float[np.ndarray, " n"],
    half: Float[np.ndarray, " n"],
    expected: float,
    title: str,
) -> Drawing:
    size = (7.0, 1.2 + LINE * len(names))
    drawing = Drawing(figsize=size, layout="constrained")
    axes = drawing.subplots()
    places = np.arange(len(names))
    axes.axvline(expected, color="0.4", linewidth=0.8, linestyle="--", label="CAD")
    axes.errorbar(
        x, places, xerr=half, fmt="o", markersize=4, color=COLORS[0], label="95 %"
    )
    axes.set_yticks(places, names)
    axes.set_ylim(len(names) - 0.5, -0.5)
    axes.ticklabel_format(axis="x", useOffset=False)
    _finish(axes, title, "")
    return drawing


def _name_cells(axes: Axes, across: Sequence[str], down: Sequence[str]) -> None:
    axes.set_xticks(np.arange(len(across)), across, rotation=90, fontsize=8)
    axes.set_yticks(np.arange(len(down)), down, fontsize=8)


def _history(
    t: Float[np.ndarray, " n"], x: Float[np.ndarray, " n"]
) -> tuple[np.ndarray, np.ndarray]:
    shown = extremes(t, x)
    return with_gaps(t[shown], x[shown])


def _unit(units: Sequence[str]) -> str:
    return " or ".join(dict.fromkeys(units)).replace("^2", "²")


def _finish(axes: Axes, x: str, y: str) -> None:
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.grid(visible=True, color="0.9")
    axes.set_axisbelow(True)
    names = axes.get_legend_handles_labels()[1]
    if names:
        # Above, where no curve is.
        above = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "frameon": False}
        axes.legend(ncols=min(len(names), MOST_ACROSS), fontsize=8, **above)
