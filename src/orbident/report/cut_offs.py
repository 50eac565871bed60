"""Spectra of what was filtered, and how its cut-off frequencies were chosen."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from orbident.errors import InputError
from orbident.files.replacing import replacing
from orbident.preprocessing.low_pass import CutOff
from orbident.report.charts import (
    ERROR,
    LIMIT,
    MEASURED,
    PREDICTED,
    Figure,
    Panel,
    Trace,
    decades,
    extremes,
    label,
    line,
    stacked,
)
from orbident.report.drawing import drawn
from orbident.report.numbers import short
from orbident.report.page import Chart, Section

FORMATS = ("png", "svg")

HEIGHT = 380
"""Of a picture, pixels: it stands alone."""

FAINTEST = 1e-300
"""Zero, of a joint that stands still, has no logarithm."""

UNITS = {"gyro": "rad/s", "position": "m"}
"""Units by the beginning of a signal's name; all other signals are angles."""


def cut_offs(found: Mapping[str, CutOff]) -> Section | None:
    """A chart a signal; None where nothing was filtered.

    Args:
        found: by signal.
    """
    if not found:
        return None
    return Section(
        name="cut-offs",
        title="Spectra and cut-offs",
        words=(
            "The spectra of the first recording, the RMS of the noise, and the cut-off "
            "of each low-pass filter, where distortion and noise together are least.",
        ),
        charts=tuple(
            Chart(
                f"cut-off-{k}",
                f"{label(name)}: cut-off {short(cut_off.frequency)} Hz",
                _spectrum(cut_off, unit_of_signal(name)),
            )
            for k, (name, cut_off) in enumerate(found.items())
        ),
    )


def unit_of_signal(signal: str) -> str:
    """The unit of the signal's samples."""
    return UNITS.get(signal.split(".", 1)[0], "rad")


def draw_cut_off(cut_off: CutOff, path: str | Path, title: str, unit: str) -> None:
    """The amplitude spectrum, and the residual analysis beside it.

    Args:
        cut_off: as `choose_cut_off` found it.
        path: of the picture, PNG or SVG; an existing one is replaced.
        title: over it.
        unit: of the samples.

    Raises:
        InputError: the name ends neither in .png nor in .svg, or nothing can be
            written there.
    """
    path = Path(path)
    kind = path.suffix.lower().removeprefix(".")
    if kind not in FORMATS:
        raise InputError(f"{path}: a picture; give a name that ends in .png or .svg")
    spectrum = Chart("spectrum", "Spectrum", _spectrum(cut_off, unit))
    residual = Chart("residual", "Residual analysis", _residual(cut_off, unit))
    for chart in (spectrum, residual):
        chart.figure["layout"]["height"] = HEIGHT
    drawing = drawn([[spectrum, residual]])
    drawing.suptitle(f"{title}: cut-off {cut_off.frequency:.3g} Hz")
    with replacing(path) as target:
        # Without a date the same data give the same file.
        dateless = {"Date": None} if kind == "svg" else None
        drawing.savefig(target, format=kind, dpi=150, metadata=dateless)


def _spectrum(cut_off: CutOff, unit: str) -> Figure:
    shown = extremes(np.log(cut_off.f), cut_off.amplitude)
    f, amplitude = cut_off.f[shown], cut_off.amplitude[shown]
    curves = [line(f, np.maximum(amplitude, FAINTEST), MEASURED, name="samples")]
    if cut_off.noise_amplitude > 0:
        level = np.full(2, cut_off.noise_amplitude)
        curves.append(line(f[[0, -1]], level, ERROR, name="noise"))
    return _over_frequency(cut_off, curves, f"amplitude ({unit})", "f (Hz)")


def _residual(cut_off: CutOff, unit: str) -> Figure:
    f = cut_off.cut_offs
    residual = np.maximum(cut_off.residual, FAINTEST)
    curves = [line(f, residual, MEASURED, name="residual")]
    if cut_off.noise_std > 0:
        level = np.full(2, cut_off.noise_std)
        curves += [
            line(f, cut_off.noise_residual, PREDICTED, name="residual of noise alone"),
            line(f, cut_off.error, ERROR, name="error: distortion and noise"),
            line(f[[0, -1]], level, "--yes", name="noise of the samples"),
        ]
    return _over_frequency(cut_off, curves, f"RMS ({unit})", "cut-off frequency (Hz)")


def _over_frequency(cut_off: CutOff, curves: list[Trace], y: str, x: str) -> Figure:
    """Curves over frequency, and an upright line at the cut-off; both logarithmic."""
    axis = decades(curves[0]["y"])
    upright = 10.0 ** np.array(axis["range"], dtype=float)
    curves.append(line(np.full(2, cut_off.frequency), upright, LIMIT, name="cut-off"))
    return stacked([Panel(y, curves, y=axis)], x, **decades(cut_off.f))
