"""The report of a study: the paper's numbers and figures beside ours, then its RUN.

The paper's Figs. 6 to 13, and the errors of its Table 4, drawn as in the paper.

The section of the study of a real table.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from orbident.estimation.checks import Check, worst
from orbident.estimation.result import Result
from orbident.files.text import write_text
from orbident.identified.run_folder import REPORT
from orbident.report.cut_offs import cut_offs
from orbident.report.drawing import Axes, Drawing, kept
from orbident.report.numbers import NONE, short, with_std
from orbident.report.page import (
    Picture,
    ReportTable,
    Section,
    TableRow,
    page,
    verdict_of,
)
from orbident.report.write import sections_of, seen
from orbident.studies.control import ControlStudy
from orbident.studies.paper_tables import PLANAR_IDENTIFIED, PaperRow
from orbident.studies.planar_run import Figure
from orbident.studies.run_planar import PlanarStudy
from orbident.studies.run_spatial import SpatialStudy
from orbident.studies.run_table import Acted, TableStudy
from orbident.studies.run_table import MethodParameter as Parameter

COLORS = "#4477aa", "#ee6677", "#228833", "#ccbb44"
"""Told apart by the colour-blind too (Tol 2021, bright)."""

QUANTITIES = {
    "rad": "angle (rad)",
    "rad/s": "rate (rad/s)",
    "m": "position (m)",
    "m/s": "velocity (m/s)",
    "N": "force (N)",
}
"""The words on an axis, by unit."""

PREDICTED = " predicted"
"""How the names of predicted curves end."""

EXACT = 1e-14
"""Percent: errors are drawn no smaller, and zero has no logarithm."""


def draw_figures(figures: Mapping[str, Figure], folder: Path) -> tuple[Picture, ...]:
    """Each as `fig06.png`, `fig06.svg` and so on; the same for a report.

    Args:
        figures: by name.
        folder: that exists.

    Raises:
        InputError: nothing can be written there.
    """
    return tuple(
        kept(_figure(figure), folder / name, f"Fig. {int(name[3:])}. {figure.title}")
        for name, figure in figures.items()
    )


def draw_errors(rows: Sequence[PaperRow], path: Path, title: str) -> Picture:
    """Errors of a table's parameters, the paper's and ours, as PNG and SVG.

    Args:
        rows: of the table.
        path: without a suffix.
        title: over it.

    Raises:
        InputError: nothing can be written there.
    """
    drawing = Drawing(figsize=(10.0, 4.2), layout="constrained")
    axes = drawing.subplots()
    places = np.arange(len(rows))
    curves = {
        "paper": ([row.paper_error_percent for row in rows], "D"),
        "estimate": ([row.error_percent for row in rows], "o"),
        "RMS over seeds": ([row.rms_error_percent for row in rows], "s"),
        "Cramér-Rao bound": ([row.cramer_rao_percent for row in rows], "_"),
    }
    for (name, (errors, marker)), color in zip(curves.items(), COLORS, strict=True):
        size = np.abs(np.array(errors, dtype=float))
        if np.isfinite(size).any():
            size = np.maximum(size, EXACT)
            axes.plot(places, size, marker, color=color, label=name, fillstyle="none")
    axes.set(yscale="log", ylabel="relative error (%)")
    axes.set_xticks(places, [row.name for row in rows], rotation=90)
    _finish(axes)
    return kept(drawing, path, title)


def _figure(figure: Figure) -> Drawing:
    t_name, *names = figure.columns
    panels = _panels(names)
    drawing = Drawing(figsize=(7.0, 2.4 * len(panels)), layout="constrained")
    every = drawing.subplots(len(panels), sharex=True, squeeze=False)[:, 0]
    for axes, curves in zip(every, panels, strict=True):
        for k, name in enumerate(curves):
            foreseen = PREDICTED in name
            axes.plot(
                figure.columns[t_name],
                figure.columns[name],
                color=COLORS[k % len(COLORS)],
                linestyle="--" if foreseen else "-",
                linewidth=1.2 if foreseen or len(curves) == 1 else 1.6,
                label=_parted(name)[0],
            )
        axes.set_ylabel(QUANTITIES[_parted(curves[0])[1]])
        _finish(axes)
    every[-1].set_xlabel(t_name)
    return drawing


def _panels(names: Sequence[str]) -> list[list[str]]:
    """A measured curve and its prediction together; else what has the same unit."""
    foreseen = any(PREDICTED in name for name in names)
    panels: dict[str, list[str]] = {}
    for name in names:
        what, unit = _parted(name)
        panels.setdefault(what.replace(PREDICTED, "") if foreseen else unit, []).append(
            name
        )
    return list(panels.values())


def _parted(name: str) -> tuple[str, str]:
    """`"S x (m)"` in name and unit."""
    what, _, unit = name.rpartition(" (")
    return what, unit.removesuffix(")")


def _finish(axes: Axes) -> None:
    axes.grid(visible=True, color="0.9")
    axes.set_axisbelow(True)
    axes.margins(x=0.02)
    # Above, where no curve is.
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, frameon=False)


WAYS = {
    "paper": "The paper's method",
    "without": "Maximum likelihood, as if nothing acted",
    "with": "Maximum likelihood, with what acts",
}
"""How each way of reading is headed."""

PARAMETER = "parameter", "true", "estimate", "error (%)", "RMS (%)", "sigmas"
DISTURBANCE = "disturbance", "true", "estimate", "deviation", "sigmas"


def real_table(done: TableStudy) -> Section:
    """Table 6 by three ways of reading, and what acted."""
    paper = "accepts its first result"
    if done.refused:
        paper = f"refuses its first result: {done.refused}"
    parameters = [
        ReportTable(
            f"{words}: pi, kg m²; phi, m; M, kg",
            PARAMETER,
            tuple(_parameter(row) for row in done.methods[way]),
        )
        for way, words in WAYS.items()
    ]
    acted = tuple(_disturbance(each) for each in done.acted)
    return Section(
        name="table",
        title="A real table",
        words=(
            "Section 5 on a table that is tilted and uneven, with an air film below "
            "base and elbow, by encoders and motion capture.",
            f"Maximum likelihood refuses {done.rejected} of {done.seeds} results; the "
            f"paper's method {paper}.",
        ),
        tables=(*parameters, ReportTable("What acted", DISTURBANCE, acted)),
    )


def _parameter(row: Parameter) -> TableRow:
    percent = short(row.error_percent, 2), short(row.rms_error_percent, 2)
    numbers = short(row.true, 4), short(row.estimate, 4)
    return TableRow((row.name, *numbers, *percent, short(row.sigmas, 2)))


def _disturbance(each: Acted) -> TableRow:
    numbers = (short(x, 3) for x in (each.true, each.estimate, each.std))
    return TableRow((f"{each.name}, {each.unit}", *numbers, short(each.sigmas, 2)))


Study = SpatialStudy | PlanarStudy | TableStudy | ControlStudy


def write_study_report(done: Study, result: Result, title: str, folder: Path) -> Path:
    """Write a study's report and the pictures in it.

    Args:
        done: the study.
        result: its own, of the recording in the folder.
        title: of the page.
        folder: that exists.

    Raises:
        InputError: nothing can be written there.
    """
    first = own_sections(done, folder)
    signals = seen(result)
    verdict = verdict_of(result)
    level = "trust" if done.trusted else "do not trust"
    reason = f"the study's aim is {'' if done.trusted else 'not '}met"
    checks = Check("aim of the study", level, reason), *verdict.checks
    known_as = "CAD" if isinstance(done, ControlStudy) else "truth"
    text = page(
        title=title,
        subtitle=f"{done.seeds} run{'' if done.seeds == 1 else 's'}; below, the first",
        verdict=verdict._replace(level=worst(checks), checks=checks),
        sections=[*first, *sections_of(result, signals, known_as=known_as)],
    )
    path = folder / REPORT
    write_text(path, text)
    return path


def own_sections(done: Study, folder: Path) -> Sequence[Section]:
    """What is a study's own; its pictures go to the folder."""
    match done:
        case SpatialStudy():
            return _spatial(done, folder)
        case PlanarStudy():
            return _planar(done, folder)
        case TableStudy():
            return [real_table(done), *_present(cut_offs(done.cut_offs))]
        case ControlStudy():
            return _control(done)


def _spatial(done: SpatialStudy, folder: Path) -> Sequence[Section]:
    title = "Table 4: relative errors, " + ("with noise" if done.noisy else "no noise")
    table = Section(
        name="table4",
        title="Table 4",
        words=(
            f"The paper's spatial servicer, by {_method(done.method)}.",
            _conditions(done.condition_number),
        ),
        tables=(
            ReportTable("Parameters: pi, kg m²; phi, m; M, kg", *_columns(done.rows)),
        ),
        pictures=(draw_errors(done.rows, folder / "table4", title),),
    )
    return [table, *_present(cut_offs(done.cut_offs))]


def _planar(done: PlanarStudy, folder: Path) -> Sequence[Section]:
    tables = [
        ReportTable(
            f"By {_method(name)}: pi, kg m²; phi, m; M, kg",
            *_columns([_beside_table6(row) for row in method.rows], "identified", 4),
        )
        for name, method in done.methods.items()
    ]
    weighed = [
        replace(row, name=words)
        for words, row in (
            ("all samples (weigh)", done.mass.row),
            ("two slopes (paper)", done.mass.slopes),
        )
    ]
    table6 = Section(
        name="table6",
        title="Table 6 and the burn",
        words=(
            "A stand-in for Cepheus on its table; the paper's robot is another one, so "
            "only orders of magnitude can be compared. " + _predicted(done),
            _conditions(done.condition_number),
        ),
        tables=(
            *tables,
            ReportTable("Mass by the burn (Eq. 40), kg", *_columns(weighed, "weighed")),
        ),
    )
    figures = Section(
        name="figures",
        title="Figs. 6 to 13",
        words=("With the paper's axes; data beside this page as CSV.",),
        pictures=draw_figures(done.figures, folder),
    )
    return [table6, figures, *_present(cut_offs(done.cut_offs))]


def _control(done: ControlStudy) -> Sequence[Section]:
    rows = tuple(
        TableRow((f"the {name} model", short(tracked.joints), short(tracked.base)))
        for name, tracked in done.errors.items()
    )
    head = "torques computed from", "joints, rad RMS", "base, rad RMS"
    return [
        Section(
            name="tracking",
            title="Tracking",
            words=(
                "Arm and base tracked in free flight, CAD off by 20 % in masses, first "
                f"moments and inertias: at least {short(done.factor)} times better "
                "with the identified model.",
            ),
            tables=(ReportTable("Tracking errors", head, rows),),
        )
    ]


def _columns(
    rows: Sequence[PaperRow], paper: str = "true", decimals: int = 2
) -> tuple[tuple[str, ...], tuple[TableRow, ...]]:
    """Head and rows of a table, without columns in which nothing stands."""
    head = (
        *("parameter", f"paper: {paper}", "paper: error (%)", "true", "estimate"),
        *("error (%)", "RMS (%)", "worst (%)", "Cramér-Rao (%)"),
    )
    cells = [
        (
            row.name,
            NONE if row.paper_true is None else f"{row.paper_true:.{decimals}f}",
            short(row.paper_error_percent, 2),
            *(with_std(x, row.estimate - row.true) for x in (row.true, row.estimate)),
            short(row.error_percent, 2),
            short(row.rms_error_percent, 2),
            short(row.worst_error_percent, 2),
            short(row.cramer_rao_percent, 2),
        )
        for row in rows
    ]
    used = [any(row[k] != NONE for row in cells) for k in range(len(head))]

    def kept(row: Sequence[str]) -> tuple[str, ...]:
        return tuple(cell for cell, use in zip(row, used, strict=True) if use)

    return kept(head), tuple(TableRow(kept(row)) for row in cells)


def _method(name: str) -> str:
    return "the paper's method" if name == "paper" else name.replace("-", " ")


def _beside_table6(row: PaperRow) -> PaperRow:
    """The row with what the paper identified, but for M: the paper's is the burn's."""
    paper = None if row.name == "M" else PLANAR_IDENTIFIED[row.name]
    return replace(row, paper_true=paper)


def _conditions(found: dict[str, float]) -> str:
    return (
        f"Condition numbers in the paper's basis: Y {short(found['Y'])}, "
        f"W {short(found['W'])}."
    )


def _predicted(done: PlanarStudy) -> str:
    scores = done.main.validation.first
    if scores is None:
        return "Eq. 47's run was not predicted."
    errors = ", ".join(
        f"{words} to {short(100 * scores.nrmse[name], 2)} %"
        for name, words in (("gyro", "base rate"), ("velocity", "velocity of S"))
    )
    return f"Eq. 47's run was predicted: {errors} of the signal."


def _present(section: Section | None) -> list[Section]:
    return [] if section is None else [section]
