"""The report of a study: the paper's numbers and figures beside ours, then its RUN."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from orbident.estimation.check import Check, worst
from orbident.estimation.result import Result
from orbident.files.text import write_text
from orbident.identified.run_folder import REPORT
from orbident.report.cut_offs import cut_offs
from orbident.report.numbers import NONE, short, with_std
from orbident.report.page import page
from orbident.report.paper_figures import draw_errors, draw_figures
from orbident.report.real_table import real_table
from orbident.report.section import ReportTable, Section, TableRow
from orbident.report.verdict import verdict_of
from orbident.report.write import sections_of, seen
from orbident.studies.control import ControlStudy
from orbident.studies.paper_tables import PLANAR_IDENTIFIED, PaperRow
from orbident.studies.run_planar import PlanarStudy
from orbident.studies.run_spatial import SpatialStudy
from orbident.studies.run_table import TableStudy

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
