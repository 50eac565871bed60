"""What was measured against what is predicted, and what is left."""

from collections.abc import Iterator

import numpy as np

from orbident.estimation.result import Result
from orbident.estimation.signals import Signal, Signals, sensor_of
from orbident.report.charts import (
    ERROR,
    LIMIT,
    MEASURED,
    PREDICTED,
    Figure,
    Panel,
    decades,
    history,
    line,
    stacked,
)
from orbident.report.numbers import NINETY_FIVE, NONE, short
from orbident.report.section import Chart, ReportTable, Section, TableRow
from orbident.report.spectra import autocorrelation, residuals, spectrum

SENSORS = "Every sensor, as momentum conservation predicts it with these parameters."
EQUATIONS = (
    "The two linear equations with these parameters: momentum of base and arms "
    "(Eq. 24), and velocity of S beside that of the system CM (Eq. 31), base axes."
)
ATTITUDE = " For attitude, the rotation from predicted to measured is shown."

UNITS = {
    "gyro": "rad/s",
    "accelerometer": "m/s²",
    "attitude": "rad",
    "position": "m",
    "velocity": "m/s",
    "joints": "rad or m",
    "momentum": "N m s",
}


def fits(result: Result, signals: Signals) -> Section | None:
    """All charts of one signal beside each other; None where nothing was predicted."""
    if not signals:
        return None
    words = SENSORS if "sensors" in result.residual else EQUATIONS
    if any(signal.sensor == "attitude" for signal in signals):
        words += ATTITUDE
    return Section(
        name="fit",
        title="Measured and predicted",
        words=(
            f"{words} Bands are 95 % of the noise found; curves have as many points "
            "as a screen can show.",
        ),
        tables=tuple(_tables(result)),
        charts=tuple(chart for signal in signals for chart in _charts(signal)),
    )


def _tables(result: Result) -> Iterator[ReportTable]:
    sensors = result.residual.get("sensors", {})
    if sensors:
        rows = tuple(
            TableRow(
                (
                    f"{name}, {_unit_of(name)}",
                    short(fit["rms"], 2),
                    short(fit["noise"], 2),
                    short(fit["declared"], 2),
                    NONE if fit["whiteness"] is None else f"{fit['whiteness']:.2f}",
                    str(fit["samples"]),
                )
            )
            for name, fit in sensors.items()
        )
        head = ("sensor", "RMS", "noise", "declared", "whiteness", "samples")
        yield ReportTable("Residuals", head, rows)
    else:
        rows = tuple(
            TableRow((f"{name}, {_unit_of(name)}", short(rms, 2)))
            for name, rms in result.residual.get("rms", {}).items()
        )
        yield ReportTable("Residuals", ("equation", "RMS"), rows)
    if result.biases:
        rows = tuple(
            TableRow(
                (
                    f"{name}, {_unit_of(name)}",
                    short(b["value"]),
                    short(b["std"], 2),
                )
            )
            for name, b in result.biases.items()
        )
        yield ReportTable("Biases", ("sensor", "bias", "± std"), rows)


def _unit_of(name: str) -> str:
    """The unit of a sensor, or of one of its axes."""
    return UNITS[sensor_of(name).split(".")[0]]


def _charts(signal: Signal) -> Iterator[Chart]:
    name = signal.name
    whole = signal.sensor != "attitude"
    if whole:
        title = f"{name}: measured, predicted"
        yield Chart(f"{name}-signal", title, _signal(signal), first=True)
    title = f"{name}: residuals"
    yield Chart(f"{name}-residual", title, _residual(signal), first=not whole)
    yield Chart(f"{name}-spectrum", f"{name}: spectrum of residuals", _spectrum(signal))
    yield Chart(f"{name}-lags", f"{name}: whiteness of residuals", _lags(signal))


def axis_labels(signal: Signal) -> list[str]:
    """Each axis with its unit: `x (rad/s)`."""
    return [
        f"{axis} ({_unit(unit)})"
        for axis, unit in zip(signal.axes, signal.units, strict=True)
    ]


def _unit(unit: str) -> str:
    return unit.replace("^2", "²")


def _signal(signal: Signal) -> Figure:
    panels = []
    for k, label in enumerate(axis_labels(signal)):
        names = ({"name": "measured"}, {"name": "predicted"}) if k == 0 else ({}, {})
        measured = history(signal.t, signal.measured[:, k], MEASURED, **names[0])
        measured["line"]["width"] = 3
        predicted = history(signal.t, signal.predicted[:, k], PREDICTED, **names[1])
        panels.append(Panel(label, [measured, predicted]))
    return stacked(panels, "t (s)")


def _residual(signal: Signal) -> Figure:
    panels = [
        Panel(label, [history(signal.t, e, ERROR)], band=NINETY_FIVE * signal.std)
        for label, e in zip(axis_labels(signal), residuals(signal).T, strict=True)
    ]
    return stacked(panels, "t (s)")


def _spectrum(signal: Signal) -> Figure:
    panels = []
    step = float(np.median(np.diff(signal.t)))
    level = signal.std * np.sqrt(2 * step)
    f = np.zeros(0)
    for label, e in zip(axis_labels(signal), residuals(signal).T, strict=True):
        f, density = spectrum(signal.t, e)
        ends = f[[0, -1]]
        white = line(ends, np.full(2, level), LIMIT)
        of_root = label.replace(")", "/√Hz)")
        y = decades(density, np.array([level]))
        panels.append(Panel(of_root, [line(f, density, ERROR), white], y=y))
    return stacked(panels, "f (Hz)", **decades(f))


def _lags(signal: Signal) -> Figure:
    panels = []
    for axis, e in zip(signal.axes, residuals(signal).T, strict=True):
        r = autocorrelation(e)
        bars = {
            "type": "bar",
            "x": list(range(1, r.size + 1)),
            "y": [float(f"{value:.3f}") for value in r],
            "marker": {"color": ERROR},
            "showlegend": False,
        }
        band = NINETY_FIVE / np.sqrt(e.size)
        largest = max(float(np.abs(r).max(initial=0.0)), 2 * band, 0.1)
        panels.append(Panel(axis, [bars], band=band, y={"range": [-largest, largest]}))
    return stacked(panels, "lag (samples)")
