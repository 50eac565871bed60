"""What errors of instruments would shift: a picture of the sensitivity table."""

import numpy as np
from jaxtyping import Float, Int

from orbident.estimation.output_error.sensitivity import UNSEEN
from orbident.estimation.result import Result
from orbident.estimation.sensitivity_table import SensitivityTable
from orbident.report.charts import Figure, label, numbers
from orbident.report.conditioning import COLORS
from orbident.report.section import Chart, Section

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
    size = np.nan_to_num(np.abs(table.shifts))
    rows, columns = _largest(size.max(axis=1)), _largest(size.max(axis=0))
    words = (
        "The instruments below are taken as exact: the robot file has no tolerance for "
        "them. A cell shows by how many of its own standard deviations a parameter "
        "would be off if the error were as large as its row says, all others being "
        "zero; red is upwards, blue downwards. An error with a tolerance is estimated "
        "with the parameters, or counted in their deviations. What is called unseen "
        "acts from outside, and is taken for zero because nothing shows it: its cells "
        "are the largest shifts by what is too faint to be seen. Where it may act, "
        "--disturbance with its name makes it an unknown.",
    )
    if len(rows) < len(size) or len(columns) < size.shape[1]:
        words += (
            f"The {len(columns)} of {size.shape[1]} errors that shift most, and the "
            f"{len(rows)} of {len(size)} parameters that are shifted most; result.json "
            "has all.",
        )
    chart = Chart(
        "sensitivity",
        "Shift of each parameter, in its own standard deviations",
        _heat_map(table, rows, columns),
        wide=True,
    )
    return Section("sensitivity", "Errors of instruments", words, charts=(chart,))


def error_in_words(error: str, unit: str) -> str:
    """A calibration error for people: `1 mrad: zero of elbow`.

    Args:
        error: such as `joint.elbow.zero` or `gyro.scale.x`.
        unit: that a shift is counted for; or `unseen`, of what acts from outside.
    """
    if unit == UNSEEN:
        return f"unseen: {error.replace('_', ' ')}"
    kind, _, rest = error.partition(".")
    if kind in {"joint", "wheel"}:
        name, _, what = rest.rpartition(".")
        return f"1 {unit}: {what} of {name}"
    return f"1 {unit}: {error.replace('.', ' ').replace('_', ' ')}"


def _largest(size: Float[np.ndarray, " n"]) -> Int[np.ndarray, " most"]:
    """The `MOST` largest, in their order."""
    return np.sort(np.argsort(-size, kind="stable")[:MOST])


def _heat_map(
    table: SensitivityTable,
    rows: Int[np.ndarray, " rows"],
    columns: Int[np.ndarray, " columns"],
) -> Figure:
    shifts = table.shifts[np.ix_(rows, columns)].T
    # Colours go with the logarithm: shifts of 1 and of 100 are to be told apart.
    z = np.sign(shifts) * np.log10(1 + np.abs(shifts))
    full = max(np.log10(1 + STRONG), float(np.nanmax(np.abs(z))))
    errors = [error_in_words(table.errors[k], table.units[k]) for k in columns]
    names = [table.parameters[k] for k in rows]
    return {
        "data": [
            {
                "type": "heatmap",
                "z": {**numbers(z, "<f4"), "shape": f"{len(errors)}, {len(names)}"},
                "text": [[_cell(shift) for shift in row] for row in shifts],
                "texttemplate": "%{text}",
                "textfont": {"size": 10},
                "zmin": -full,
                "zmax": full,
                "colorscale": COLORS,
                "showscale": False,
                "showlegend": False,
                "xgap": 1,
                "ygap": 1,
                "hovertemplate": "%{y} would shift %{x} by %{text}<extra></extra>",
            }
        ],
        "layout": {
            "height": 26 * len(errors) + 90,
            "margin": {"t": 12, "b": 64},
            "xaxis": {**_ticks(names), "tickangle": -90},
            "yaxis": {**_ticks(errors), "autorange": "reversed"},
        },
    }


def _ticks(names: list[str]) -> Figure:
    return {
        # Numbered: shortened names may be alike.
        "tickvals": list(range(len(names))),
        "ticktext": [label(name) for name in names],
        "showgrid": False,
        "automargin": True,
    }


def _cell(shift: float) -> str:
    """Its size, short enough for a cell; the colour has its sign."""
    if not np.isfinite(shift):
        return ""
    size = abs(shift)
    return f"{size:.1f}" if size < 9.95 else f"{size:.0f}" if size < 9999.5 else "≫"
