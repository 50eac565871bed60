"""What errors of instruments would shift: a picture of the sensitivity table."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from orbident.estimation.result import Result
from orbident.estimation.sensitivity_table import SensitivityTable
from orbident.report.charts import heat_map
from orbident.report.page import Chart, Section

MOST = 20
"""Rows and columns of which the numbers can be read."""

STRONG = 100.0
"""Deviations: a colour is full there, or at the largest shift if that is larger."""


def sensitivities(result: Result) -> Section | None:
    """How calibration errors that are taken for zero would shift the parameters.

    None where every error has a tolerance, or where shifts are not known: of a refused
    result, or of exact data.
    """
    table = result.sensitivity()
    if table is None or not np.isfinite(table.shifts).any():
        return None
    shown = largest_shifts(table)
    parameters, errors = table.shifts.shape
    words = (
        "The instruments below are taken as exact: the robot file has no tolerance for "
        "them. A cell shows by how many of its own standard deviations a parameter "
        "would be off if the error were as large as its row says, all others being "
        "zero; red is upwards, blue downwards. An error with a tolerance is estimated "
        "with the parameters, or counted in their deviations.",
    )
    if shown.x.size < table.shifts.size:
        words += (
            f"The {len(shown.errors)} of {errors} errors that shift most, and the "
            f"{len(shown.parameters)} of {parameters} parameters that are shifted "
            "most; result.json has all.",
        )
    chart = Chart(
        "sensitivity",
        "Shift of each parameter, in its own standard deviations",
        heat_map(
            *(shown.errors, shown.parameters, shown.colour, shown.full),
            height=26 * len(shown.errors) + 90,
            text=shown.cells,
            texttemplate="%{text}",
            textfont={"size": 10},
            showscale=False,
            xgap=1,
            ygap=1,
            hovertemplate="%{y} would shift %{x} by %{text}<extra></extra>",
        ),
        wide=True,
    )
    return Section("sensitivity", "Errors of instruments", words, charts=(chart,))


def error_in_words(error: str, unit: str) -> str:
    """A calibration error for people: `1 mrad: zero of elbow`.

    Args:
        error: such as `joint.elbow.zero` or `gyro.scale.x`.
        unit: that a shift is counted for.
    """
    kind, _, rest = error.partition(".")
    if kind in {"joint", "wheel"}:
        name, _, what = rest.rpartition(".")
        return f"1 {unit}: {what} of {name}"
    return f"1 {unit}: {error.replace('.', ' ').replace('_', ' ')}"


class Shifts(NamedTuple):
    """Part of a sensitivity table, for people: a row an error."""

    errors: list[str]
    parameters: list[str]
    x: Float[np.ndarray, "errors parameters"]
    """Shifts, in each parameter's own standard deviations,"""
    colour: Float[np.ndarray, "errors parameters"]
    """and what decides their colours: shifts of 1 and of 100 are to be told apart."""
    full: float
    """Where a colour is full."""
    cells: list[list[str]]


def largest_shifts(table: SensitivityTable) -> Shifts:
    """The errors that shift most, and the parameters that are shifted most."""
    size = np.nan_to_num(np.abs(table.shifts))
    rows, columns = _largest(size.max(axis=1)), _largest(size.max(axis=0))
    x = table.shifts[np.ix_(rows, columns)].T
    colour = np.sign(x) * np.log10(1 + np.abs(x))
    return Shifts(
        errors=[error_in_words(table.errors[k], table.units[k]) for k in columns],
        parameters=[table.parameters[k] for k in rows],
        x=x,
        colour=colour,
        full=max(np.log10(1 + STRONG), float(np.nanmax(np.abs(colour)))),
        cells=[[_cell(shift) for shift in row] for row in x],
    )


def _largest(size: Float[np.ndarray, " n"]) -> Int[np.ndarray, " most"]:
    """The `MOST` largest, in their order."""
    return np.sort(np.argsort(-size, kind="stable")[:MOST])


def _cell(shift: float) -> str:
    """Its size, short enough for a cell; the colour has its sign."""
    if not np.isfinite(shift):
        return ""
    size = abs(shift)
    return f"{size:.1f}" if size < 9.95 else f"{size:.0f}" if size < 9999.5 else "≫"
