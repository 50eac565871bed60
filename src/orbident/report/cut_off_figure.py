"""A picture of how a cut-off frequency was chosen."""

from pathlib import Path

import numpy as np

from orbident.errors import InputError
from orbident.files.replacing import replacing
from orbident.preprocessing.low_pass import CutOff
from orbident.report.drawing import Axes, Drawing

FORMATS = ("png", "svg")

SIGNAL, NOISE, ERROR, CHOSEN = "#4477aa", "#ee6677", "#228833", "#333333"
"""Told apart by the colour-blind too (Tol 2021, bright)."""

MOST_POINTS = 4000
"""Most points of the spectrum: more than a picture has columns."""


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
    figure = Drawing(figsize=(10.0, 4.2), layout="constrained")
    spectrum, residual = figure.subplots(1, 2)
    _spectrum(spectrum, cut_off, unit)
    _residual(residual, cut_off, unit)
    figure.suptitle(f"{title}: cut-off {cut_off.frequency:.3g} Hz")
    with replacing(path) as target:
        # Without a date the same data give the same file.
        dateless = {"Date": None} if kind == "svg" else None
        figure.savefig(target, format=kind, dpi=150, metadata=dateless)


def _spectrum(axes: Axes, cut_off: CutOff, unit: str) -> None:
    f, amplitude = _thinned(cut_off.f, cut_off.amplitude)
    _scale(axes, cut_off, amplitude)
    axes.plot(f, amplitude, color=SIGNAL, linewidth=0.8, label="samples")
    if cut_off.noise_amplitude > 0:
        label = "noise, RMS of a line"
        axes.axhline(cut_off.noise_amplitude, color=NOISE, label=label)
    _mark(axes, cut_off)
    axes.set(title="Spectrum", xlabel="frequency (Hz)", ylabel=f"amplitude ({unit})")


def _residual(axes: Axes, cut_off: CutOff, unit: str) -> None:
    f = cut_off.cut_offs
    _scale(axes, cut_off, cut_off.residual)
    axes.plot(f, cut_off.residual, color=SIGNAL, label="residual")
    if cut_off.noise_std > 0:
        label = "residual of noise alone"
        axes.plot(f, cut_off.noise_residual, color=NOISE, ls="--", label=label)
        label = "error: distortion and noise"
        axes.plot(f, cut_off.error, color=ERROR, label=label)
        label = "noise of the samples"
        axes.axhline(cut_off.noise_std, color=NOISE, linewidth=0.8, label=label)
    _mark(axes, cut_off)
    axes.set(
        title="Residual analysis",
        xlabel="cut-off frequency (Hz)",
        ylabel=f"RMS ({unit})",
    )


def _scale(axes: Axes, cut_off: CutOff, values: np.ndarray) -> None:
    axes.set(xscale="log", xlim=(cut_off.f[0], cut_off.f[-1]))
    # A joint that stands still has nothing that has a logarithm.
    if (values > 0).any():
        axes.set_yscale("log")


def _mark(axes: Axes, cut_off: CutOff) -> None:
    label = f"cut-off {cut_off.frequency:.3g} Hz"
    axes.axvline(cut_off.frequency, color=CHOSEN, linestyle=":", label=label)
    axes.grid(visible=True, which="major", color="0.9")
    axes.set_axisbelow(True)
    axes.legend(loc="upper right")


def _thinned(f: np.ndarray, amplitude: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The largest line in each of as many bands as can be seen."""
    if f.size <= MOST_POINTS:
        return f, amplitude
    starts = np.unique(np.searchsorted(f, np.geomspace(f[0], f[-1], MOST_POINTS)))
    return f[starts], np.maximum.reduceat(amplitude, starts)
