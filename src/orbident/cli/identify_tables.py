"""What `identify` prints: the identifiable parameters first, all else on request."""

from pathlib import Path
from typing import Any

from orbident.data_table import Numeric
from orbident.estimation.parameter_table import HEAD, parameter_line, parameter_rows
from orbident.report.parameter_section import mass_rows, routes_left_out

TITLES = {
    "base": "base parameters: what free floating can identify",
    "phi": "phi: what the velocity of S shows",
    "pi": "pi: what the angular momentum shows",
}


def summary(result: Any, out: Path | None, everything: bool) -> list[str]:
    """The lines of a result, on one screen of 24 lines unless everything is wanted.

    Args:
        result: of an identification.
        out: the RUN that keeps it, if any.
        everything: also `pi`, `phi`, the mass by every route, residuals of sensors.
    """
    written = [] if out is None else [f"written: {out}"]
    if result.status == "rejected":
        return [*result.summary(), *written]
    if everything:
        lines = [*result.summary()[:2], *_everything(result), *_sensitivity(result)]
        return [*lines, *written]
    return [
        *result.summary(),
        "",
        *_goodness(result),
        *_sensitivity(result),
        "--all shows formulas, pi, phi and the mass by every route; so does --json",
        *written,
    ]


def _everything(result: Any) -> list[str]:
    lines = []
    for name, title in TITLES.items():
        found = getattr(result, name)
        rows = parameter_rows(found, range(len(found.names)))
        whole = (f"{parameter_line(row):75} {row.note}" for row in rows)
        lines += ["", title, HEAD, *whole]
    lines += _masses(result)
    lines += _sensors(result)
    lines += _calibration(result)
    lines += _disturbances(result)
    condition = ", ".join(
        f"{name} {value:.4g}" for name, value in result.condition_number.items()
    )
    return [*lines, "", f"condition numbers: {condition}", ""]


def _masses(result: Any) -> list[str]:
    """The mass by every route."""
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
        f"tolerance {fit.tolerance:.2g}"
        for name, fit in result.calibration.items()
    ]
    return ["", "calibration errors, SI or relative", *lines] if lines else []


def _disturbances(result: Any) -> list[str]:
    """What acted from outside."""
    lines = [
        f"  {name:24} {fit.value:10.2g} +- {fit.std:.2g} {fit.unit}"
        for name, fit in result.disturbances.items()
    ]
    return ["", "from outside", *lines] if lines else []


def _sensitivity(result: Any) -> list[str]:
    """What errors of instruments that are taken for zero may do."""
    table = result.sensitivity()
    if table is None:
        return []
    name, unit, parameter, shift = table.worst()
    return [
        f"{len(table.errors)} errors of instruments are taken for zero: 1 {unit} of "
        f"{name} would",
        f"shift {parameter} by {Numeric(shift, '.2g')} sigmas (see 'tolerances' in the "
        "docs; all: --json)",
    ]
