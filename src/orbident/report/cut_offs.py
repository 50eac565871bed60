"""Spectra of what was filtered, with the cut-offs."""

from collections.abc import Mapping

import numpy as np

from orbident.preprocessing.low_pass import CutOff
from orbident.report.charts import (
    ERROR,
    LIMIT,
    MEASURED,
    Figure,
    Panel,
    decades,
    extremes,
    label,
    line,
    stacked,
)
from orbident.report.numbers import short
from orbident.report.page import Chart, Section

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
                _spectrum(name, cut_off),
            )
            for k, (name, cut_off) in enumerate(found.items())
        ),
    )


def unit_of_signal(signal: str) -> str:
    """The unit of the signal's samples."""
    return UNITS.get(signal.split(".", 1)[0], "rad")


def _spectrum(name: str, cut_off: CutOff) -> Figure:
    shown = extremes(np.log(cut_off.f), cut_off.amplitude)
    f, amplitude = cut_off.f[shown], np.maximum(cut_off.amplitude[shown], 1e-300)
    y = decades(amplitude)
    upright = 10.0 ** np.array(y["range"], dtype=float)
    traces = [
        line(f, amplitude, MEASURED, name="samples"),
        line(np.full(2, cut_off.frequency), upright, LIMIT, name="cut-off"),
    ]
    if cut_off.noise_amplitude > 0:
        level = np.full(2, cut_off.noise_amplitude)
        traces.append(line(f[[0, -1]], level, ERROR, name="noise"))
    panel = Panel(f"amplitude ({unit_of_signal(name)})", traces, y=y)
    return stacked([panel], "f (Hz)", **decades(f))
