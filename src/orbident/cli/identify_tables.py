"""What `identify` prints: the identifiable parameters first, all else on request."""

import math
from collections.abc import Iterator
from pathlib import Path
from textwrap import wrap
from typing import Any

from orbident.cli.output import with_sign
from orbident.data_table import DataTable, Numeric, TableRow
from orbident.estimation.checks import VERDICTS
from orbident.estimation.quantities import parameter_rows
from orbident.files.names import counted
from orbident.model.core_robot import IN_FORMULAS, geared_joints
from orbident.model.formulas import named
from orbident.report.parameter_section import (
    TITLES,
    drive_table,
    mass_rows,
    routes_left_out,
    spring_table,
)

NOTES = 2
"""Notes that are printed with a refusal: it has eight lines at most."""

LITTLE = 1.05
"""Times: what widens deviations by less is not worth a number."""

HEAD = f"  {'':10} {'estimate':>12} {'std':>9} {'CAD':>12} {'sigmas':>8} {'%':>8}"
"""`sigmas` and `%`: the difference from CAD in standard deviations, and in percent."""

COLUMNS = 80
"""The width of a terminal, as it opens nearly everywhere."""


def summary(result: Any, out: Path | None, everything: bool) -> list[str | DataTable]:
    """The lines of a result, on one screen of 24 lines unless everything is wanted.

    With everything come `pi`, `phi`, the mass by every route, residuals of sensors.
    """
    written = [] if out is None else [f"written: {out}"]
    head, *rest = result.summary()
    head = with_sign(head, VERDICTS[result.level])
    if result.status == "rejected":
        more = len({*result.warnings} - {*warnings_of(result, everything)})
        checks = counted(more, "more check")
        hidden = [f"{checks} failed: --all and --json show all"] if more else []
        return [head, *rest, *hidden, *written]
    if everything:
        lines = [head, rest[0], *_everything(result), *_joints(result)]
        lines += [*_sensitivity(result), *budget_lines(result.budget())]
        return [*lines, *written]
    return [
        head,
        *rest,
        "",
        *_goodness(result),
        *_joints(result),
        *_limits(result.budget()),
        *_outside(result),
        *_sensitivity(result),
        "--all shows formulas, pi, phi and the mass by every route; so does --json",
        *written,
    ]


def warnings_of(result: Any, everything: bool) -> list[str]:
    """What is warned of; of a refused result its reasons alone, unless all is asked."""
    if everything or result.status != "rejected":
        return [*result.warnings]
    return [*result.refusal_in_brief(), *result.notes[:NOTES]]


def _everything(result: Any) -> list[str]:
    lines = []
    for name, title in TITLES.items():
        found = getattr(result, name)
        if not found.names:
            continue
        rows = parameter_rows(found, range(len(found.names)))
        whole = (f"{_parameter_line(row):75} {row.note}" for row in rows)
        lines += ["", title[0].lower() + title[1:], HEAD, *whole]
    if geared_joints(result.robot):
        lines += ["", IN_FORMULAS]
    lines += [*_masses(result), *_sensors(result)]
    lines += [*_calibration(result), *_disturbances(result)]
    condition = ", ".join(
        f"{name} {value:.4g}" for name, value in result.condition_number.items()
    )
    return [*lines, "", f"condition numbers: {condition}", ""]


def _parameter_line(row: TableRow) -> str:
    """A row as text, without its note."""
    name, value, std, unit, _, nominal, sigmas, percent = map(str, row.cells)
    numbers = f"{value:>12} {std:>9} {nominal:>12} {sigmas:>8} {percent:>8}"
    return f"  {name:10} {numbers}  {unit}"


def _masses(result: Any) -> list[str]:
    routes, lines = result.mass_forms, []
    for row in mass_rows(routes, range(len(routes.names))):
        name, value, std, _, sigmas = map(str, row.cells)
        lines.append(f"  {name:24} {value:>12} {std:>9} {sigmas:>8}  {row.note}")
    lines += [f"  {sentence}" for sentence in routes_left_out(routes)]
    if not lines:
        return []
    head = f"  {'':24} {'estimate':>12} {'std':>9} {'sigmas':>8}"
    title = (
        "mass by every route, kg; sigmas: forms (M from ..) are compared with Eq. 32,"
    )
    more = "which combines them, and the routes with the last of them"
    return ["", title, more, head, *(line.rstrip() for line in lines)]


def _goodness(result: Any) -> list[str]:
    chi2 = result.residual.get("chi2_per_dof")
    if chi2 is None:
        return []
    return [f"residuals: chi-square per degree of freedom {chi2:.3g}"]


def _sensors(result: Any) -> list[str]:
    """How well every sensor was predicted."""
    fits = result.residual.get("sensors", {})
    if not fits:
        return []
    width = max(14, *map(len, fits))
    head = f"{'noise':>9} {'declared':>9} {'whiteness':>9} {'samples':>8}"
    lines = ["", *_goodness(result), f"  {'SI':{width}} {head}"]
    for name, fit in fits.items():
        declared = "-" if fit["declared"] is None else f"{fit['declared']:.2g}"
        lines.append(
            f"  {name:{width}} {fit['noise']:9.2g} {declared:>9} "
            f"{fit['whiteness']:9.2f} {fit['samples']:8.0f}"
        )
    return lines


def _calibration(result: Any) -> list[str]:
    """Errors of instruments that were estimated."""
    lines = [
        f"  {name:24} {fit.value:10.2g} +- {fit.std:.2g}   "
        + ("free" if math.isnan(fit.tolerance) else f"tolerance {fit.tolerance:.2g}")
        for name, fit in result.calibration.items()
    ]
    return ["", "calibration errors, SI or relative", *lines] if lines else []


def _joints(result: Any) -> list[str | DataTable]:
    """How passive joints swing, and what the others drive against."""
    tables = spring_table(result), drive_table(result)
    return [table for table in tables if table.rows]


def _disturbances(result: Any) -> list[str]:
    """What acted from outside."""
    lines = [
        f"  {name:24} {fit.value:10.2g} +- {fit.std:.2g} {fit.unit}"
        for name, fit in result.disturbances.items()
    ]
    lines += [
        f"  {name:24} {'may be anything' if math.isnan(size) else f'may be {size:.2g}'}"
        for name, size in result.allowed.items()
    ]
    return ["", "from outside, SI", *lines] if lines else []


def _outside(result: Any) -> list[str]:
    """What it would bring to know that nothing acts."""
    if not result.allowed:
        return []
    if result.widened_by < LITTLE:
        return ["what may act from outside widens no std (see 'disturbances')"]
    return [
        "if nothing acted from outside, std would be "
        f"{result.widened_by:.2g} times smaller (see 'disturbances')"
    ]


def _sensitivity(result: Any) -> list[str]:
    """What errors of instruments that are taken for zero may do."""
    table = result.sensitivity()
    if table is None:
        return []
    name, unit, parameter, shift = table.worst()
    if not shift:
        return []
    base = result.base
    if parameter in base.names:
        parameter = named(parameter, base.formulas[base.names.index(parameter)])
    words = (
        f"{len(table.errors)} errors of instruments are taken for zero; most critical: "
        f"{name} must be right to {Numeric(1 / shift, '.2g')} {unit}, which shifts "
        f"{parameter} by one sigma (see 'tolerances' in the docs; all: --json)"
    )
    return wrap(words, COLUMNS)


def budget_lines(budget: Any) -> Iterator[str | DataTable]:
    """What deviations are made of, and what limits the mass."""
    if budget is not None:
        yield from ("", budget.table(), "", *_limits(budget))


def _limits(budget: Any) -> list[str]:
    return [] if budget is None else wrap(budget.in_words(), COLUMNS)
