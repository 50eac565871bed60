"""The report of a study: the paper's numbers and figures beside ours, then its RUN."""

from collections.abc import Mapping, Sequence
from itertools import cycle
from pathlib import Path

import numpy as np

from orbident.estimation.checks import Check, worst
from orbident.estimation.result import Result
from orbident.estimation.signals import SIGNAL_UNITS
from orbident.files.names import counted
from orbident.files.replacing import write_text
from orbident.identified.run_folder import REPORT
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
    points,
    stacked,
)
from orbident.report.drawing import Drawing, drawn, kept
from orbident.report.page import Chart, Picture, Section, page, short, verdict_of
from orbident.report.write import sections_of
from orbident.studies.control import ControlStudy
from orbident.studies.paper_tables import PaperRow
from orbident.studies.run_planar import PaperFigure, PlanarStudy
from orbident.studies.spatial import SpatialStudy
from orbident.studies.study_account import Study, account_of

COLORS = PREDICTED, ERROR, LIMIT, MEASURED
"""Of the curves of a panel, by their number."""

HEIGHT = 360
"""Of the picture of errors, pixels: it stands alone."""

QUANTITIES = {
    "rad": "angle (rad)",
    "rad/s": "rate (rad/s)",
    "m": "position (m)",
    "m/s": "velocity (m/s)",
    "N": "force (N)",
}
"""The words on an axis, by unit."""

FORESEEN = " predicted"
"""How the names of predicted curves end."""

EXACT = 1e-14
"""Percent: errors are drawn no smaller, and zero has no logarithm."""


def draw_figures(
    figures: Mapping[str, PaperFigure], folder: Path
) -> tuple[Picture, ...]:
    """Each as `fig06.png`, `fig06.svg` and so on; the same for a report.

    Raises:
        InputError: nothing can be written there.
    """
    return tuple(
        kept(_figure(figure), folder / name, f"Fig. {int(name[3:])}. {figure.title}")
        for name, figure in figures.items()
    )


def draw_errors(rows: Sequence[PaperRow], path: Path, title: str) -> Picture:
    """Errors of a table's parameters, the paper's and ours, as PNG and SVG.

    The path is without a suffix.

    Raises:
        InputError: nothing can be written there.
    """
    x = np.arange(len(rows))
    every = {
        "paper": [row.paper_error_percent for row in rows],
        "estimate": [row.error_percent for row in rows],
        "RMS over seeds": [row.rms_error_percent for row in rows],
        "Cramér-Rao bound": [row.cramer_rao_percent for row in rows],
    }
    dots = []
    for (name, errors), color in zip(every.items(), COLORS, strict=True):
        size = np.abs(np.array(errors, dtype=float))
        if np.isfinite(size).any():
            dots.append(points(x, np.maximum(size, EXACT), color, name=name))
    panel = Panel("relative error (%)", dots, y=decades(*(each["y"] for each in dots)))
    names = {"tickvals": x, "ticktext": [row.name for row in rows]}
    figure = stacked([panel], "", **names, tickangle=-90)
    figure["layout"]["height"] = HEIGHT
    return kept(drawn([[Chart("errors", "", figure)]]), path, title)


def _figure(figure: PaperFigure) -> Drawing:
    t_name, *names = figure.columns
    panels = []
    for curves in _panels(names):
        traces = []
        for name, color in zip(curves, cycle(COLORS)):
            y, what = figure.columns[name], _parted(name)[0]
            traces.append(line(figure.columns[t_name], y, color, name=what))
            if FORESEEN in name:
                traces[-1]["line"]["dash"] = "dash"
        panels.append(Panel(QUANTITIES[_parted(curves[0])[1]], traces))
    return drawn([[Chart("figure", "", stacked(panels, t_name))]])


def _panels(names: Sequence[str]) -> list[list[str]]:
    """A measured curve and its prediction together; else what has the same unit."""
    foreseen = any(FORESEEN in name for name in names)
    panels: dict[str, list[str]] = {}
    for name in names:
        what, unit = _parted(name)
        panels.setdefault(what.replace(FORESEEN, "") if foreseen else unit, []).append(
            name
        )
    return list(panels.values())


def _parted(name: str) -> tuple[str, str]:
    """`"S x (m)"` in name and unit."""
    what, _, unit = name.rpartition(" (")
    return what, unit.removesuffix(")")


def write_study_report(done: Study, result: Result, title: str, folder: Path) -> Path:
    """Write a study's report and the pictures in it.

    The result is the study's own, of the recording in the folder.

    Raises:
        InputError: nothing can be written there.
    """
    first = own_sections(done, folder)
    verdict = verdict_of(result)
    level = "trust" if done.trusted else "do not trust"
    reason = f"the study's aim is {'' if done.trusted else 'not '}met"
    checks = Check("aim of the study", level, reason), *verdict.checks
    known_as = "CAD" if isinstance(done, ControlStudy) else "truth"
    text = page(
        title=title,
        subtitle=f"{counted(done.seeds, 'run')}; below, the first",
        verdict=verdict._replace(level=worst(checks), checks=checks),
        sections=[*first, *sections_of(result, known_as=known_as)],
    )
    path = folder / REPORT
    write_text(path, text)
    return path


def own_sections(done: Study, folder: Path) -> Sequence[Section]:
    """What is a study's own; its pictures go to the folder."""
    account, pictures, more = account_of(done), (), []
    if isinstance(done, SpatialStudy):
        noise = "with noise" if done.noisy else "no noise"
        title = f"Table 4: relative errors, {noise}"
        pictures = (draw_errors(done.rows, folder / "table4", title),)
    if isinstance(done, PlanarStudy):
        words = "With the paper's axes; data beside this page as CSV."
        drawn = draw_figures(done.figures, folder)
        more = [Section("figures", "Figs. 6 to 13", (words,), pictures=drawn)]
    filtered = None if isinstance(done, ControlStudy) else cut_offs(done.cut_offs)
    more += [] if filtered is None else [filtered]
    words = account.words
    if account.below:
        words += (f"{account.below[0].upper()}{account.below[1:]}.",)
    first = Section(account.name, account.title, words, account.tables, (), pictures)
    return [first, *more]


SPECTRUM_HEIGHT = 380
"""Of a picture, pixels: it stands alone."""

FAINTEST = 1e-300
"""Zero, of a joint that stands still, has no logarithm."""


def cut_offs(found: Mapping[str, CutOff]) -> Section | None:
    """A chart a signal; None where nothing was filtered."""
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
                _spectrum(cut_off, _unit_of(name)),
            )
            for k, (name, cut_off) in enumerate(found.items())
        ),
    )


def _unit_of(signal: str) -> str:
    """The unit of the signal's samples: of joints and wheels, of an angle."""
    return SIGNAL_UNITS.get(signal.split(".", 1)[0], "rad")


def drawn_cut_off(cut_off: CutOff, signal: str) -> Drawing:
    """The amplitude spectrum of a signal, and the residual analysis beside it."""
    unit = _unit_of(signal)
    spectrum = Chart("spectrum", "Spectrum", _spectrum(cut_off, unit))
    residual = Chart("residual", "Residual analysis", _residual(cut_off, unit))
    for chart in (spectrum, residual):
        chart.figure["layout"]["height"] = SPECTRUM_HEIGHT
    drawing = drawn([[spectrum, residual]])
    drawing.suptitle(f"{signal}: cut-off {cut_off.frequency:.3g} Hz")
    return drawing


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
