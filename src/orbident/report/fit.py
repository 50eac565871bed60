"""What was measured against what is predicted, and whether what is left is white."""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Float

from orbident.data_table import DataTable, Numeric, table_of
from orbident.estimation.result import Result
from orbident.estimation.signals import SIGNAL_UNITS, Signal, Signals, sensor_of
from orbident.gaussian import NINETY_FIVE
from orbident.report.charts import (
    ERROR,
    LIMIT,
    MEASURED,
    Figure,
    Panel,
    bars,
    decades,
    history,
    line,
    stacked,
)
from orbident.report.page import Chart, Section

SENSORS = "Every sensor, as momentum conservation predicts it with these parameters."
EQUATIONS = (
    "The two linear equations with these parameters: momentum of base and arms "
    "(Eq. 24), and velocity of S beside that of the system CM (Eq. 31), base axes."
)
ATTITUDE = " For attitude, the rotation from predicted to measured is shown."


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
            "as a screen can show. Slow parts of residuals are smaller than noise, and "
            "their first lags below zero, because what is fitted takes them up.",
        ),
        tables=tuple(_tables(result)),
        charts=tuple(chart for signal in signals for chart in charts_of(signal)),
    )


def _tables(result: Result) -> Iterator[DataTable]:
    sensors = result.residual.get("sensors", {})
    if sensors:
        rows = (
            (
                f"{name}, {_unit_of(name)}",
                *(Numeric(fit[key], ".2g") for key in ("rms", "noise", "declared")),
                Numeric(fit["whiteness"], ".2f"),
                Numeric(fit["samples"], ".0f"),
            )
            for name, fit in sensors.items()
        )
        head = ("sensor", "RMS", "noise", "declared", "whiteness", "samples")
        yield table_of("Residuals", head, rows)
    else:
        rows = (
            (f"{name}, {_unit_of(name)}", Numeric(rms, ".2g"))
            for name, rms in result.residual.get("rms", {}).items()
        )
        yield table_of("Residuals", ("equation", "RMS"), rows)
    if result.biases:
        rows = (
            (f"{name}, {_unit_of(name)}", Numeric(b["value"]), Numeric(b["std"], ".2g"))
            for name, b in result.biases.items()
        )
        yield table_of("Biases", ("sensor", "bias", "± std"), rows)


def _unit_of(name: str) -> str:
    """The unit of a sensor, or of one of its axes."""
    return _unit(SIGNAL_UNITS[sensor_of(name).split(".")[0]])


def charts_of(signal: Signal) -> Iterator[Chart]:
    """Measured and predicted (not of an attitude), residuals, spectrum, whiteness."""
    name = signal.name
    axes = signal.axes
    whole = signal.sensor != "attitude"
    if whole:
        title = f"{name}: measured, predicted"
        yield Chart(f"{name}-signal", title, _signal(signal), first=True, panels=axes)
        axes = ()
    title = f"{name}: residuals"
    over_time = [
        Panel(label, [history(signal.t, e, ERROR)], band=NINETY_FIVE * signal.std)
        for label, e in zip(axis_labels(signal), residuals(signal).T, strict=True)
    ]
    residual = stacked(over_time, "t (s)")
    yield Chart(f"{name}-residual", title, residual, first=not whole, panels=axes)
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
        # Both are seen where they agree, as they should.
        measured["line"]["width"] = 5
        predicted = history(signal.t, signal.predicted[:, k], ERROR, **names[1])
        predicted["line"]["width"] = 1.8
        panels.append(Panel(label, [measured, predicted]))
    return stacked(panels, "t (s)")


def _spectrum(signal: Signal) -> Figure:
    panels = []
    step = float(np.median(np.diff(signal.t)))
    level = signal.std * np.sqrt(2 * step)
    f = np.zeros(0)
    for label, e in zip(axis_labels(signal), residuals(signal).T, strict=True):
        f, density = spectrum(signal.t, e)
        white = line(f[[0, -1]], np.full(2, level), LIMIT)
        of_root = label.replace(")", "/√Hz)")
        y = decades(density, np.array([level]))
        panels.append(Panel(of_root, [line(f, density, ERROR), white], y=y))
    return stacked(panels, "f (Hz)", **decades(f))


def _lags(signal: Signal) -> Figure:
    panels = []
    for axis, e in zip(signal.axes, residuals(signal).T, strict=True):
        r = autocorrelation(e)
        shown = [float(f"{value:.3f}") for value in r]
        lags = bars(list(range(1, r.size + 1)), shown, ERROR)
        band = NINETY_FIVE / np.sqrt(e.size)
        largest = max(float(np.abs(r).max(initial=0.0)), 2 * band, 0.1)
        panels.append(Panel(axis, [lags], band=band, y={"range": [-largest, largest]}))
    return stacked(panels, "lag (samples)")


LAGS = 40
"""Samples."""

LINES = 2048
"""Lines of a spectrum, before it is thinned."""

DRAWN = 160
"""Bands of a spectrum, evenly spaced by logarithm."""


def residuals(signal: Signal) -> Float[np.ndarray, "n axes"]:
    """Measured less predicted."""
    return signal.measured - signal.predicted


def autocorrelation(x: Float[np.ndarray, " n"]) -> Float[np.ndarray, " lags"]:
    """Autocorrelation, at lags of 1, 2, .. samples, of what is about zero."""
    lags = min(LAGS, x.size - 1)
    power = float(x @ x) or 1.0
    return np.array([x[:-k] @ x[k:] for k in range(1, lags + 1)]) / power


def spectrum(
    t: Float[np.ndarray, " n"], x: Float[np.ndarray, " n"]
) -> tuple[Float[np.ndarray, " lines"], Float[np.ndarray, " lines"]]:
    """Frequencies, Hz, and the amplitude, the signal's unit per square root of Hz.

    They are as if the samples came evenly (Welch 1967), each the mean of a band.
    """
    rate = 1 / float(np.median(np.diff(t)))
    f, power = power_density(x, rate)
    f, power = f[1:], power[1:]
    if f.size > DRAWN:
        starts = np.unique(np.searchsorted(f, np.geomspace(f[0], f[-1], DRAWN)))
        counts = np.diff(starts, append=f.size)
        f, power = (np.add.reduceat(part, starts) / counts for part in (f, power))
    return f, np.sqrt(power)


def power_density(
    x: Float[np.ndarray, " n"], rate: float
) -> tuple[Float[np.ndarray, " lines"], Float[np.ndarray, " lines"]]:
    """Frequencies, Hz, and power per Hz by Welch's method.

    Stretches without their mean, half of each shared with the next, under Hann's
    window. `scipy.signal` has the same, and its import takes a third of a second.
    """
    size = min(x.size, 2 * LINES)
    parts = np.lib.stride_tricks.sliding_window_view(x, size)[:: -(-size // 2)]
    window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(size) / size)
    parts = (parts - parts.mean(axis=1, keepdims=True)) * window
    power = np.mean(np.abs(np.fft.rfft(parts)) ** 2, axis=0) / (rate * window @ window)
    # Both signs of a frequency share a line, but for zero and half the rate.
    power[1 : (size + 1) // 2] *= 2
    return np.fft.rfftfreq(size, 1 / rate), power
