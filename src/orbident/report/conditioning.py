"""How well the recording tells the parameters apart."""

import numpy as np

from orbident.data_table import Numeric, table_of
from orbident.estimation.result import Result
from orbident.report.charts import heat_map
from orbident.report.numbers import short
from orbident.report.page import Chart, Section

CLOSE = 0.95
"""A correlation worth a word."""

LISTED = 8
"""Pairs in a sentence."""


def conditioning(result: Result) -> Section:
    """Condition numbers, and the correlations of the base parameters."""
    words = [
        "The condition number bounds how much noise is amplified. The raw one depends "
        "on units; the normalised one is of columns scaled to unit norm."
    ]
    names, R = correlations(result)
    charts = ()
    if names:
        words.append(_close(names, R))
        charts = (
            Chart(
                "correlations",
                "Correlations of the base parameters",
                heat_map(
                    *(names, names, R, 1.0, 480),
                    colorbar={"thickness": 10, "tickvals": [-1, 0, 1]},
                    hovertemplate="%{y}, %{x}: %{z:.3f}<extra></extra>",
                ),
            ),
        )
    else:
        words.append("No correlations: no parameter is determined.")
    condition = result.condition_number
    rows = (
        (
            f"{name} ({equation})",
            Numeric(condition.get(name)),
            Numeric(condition.get(f"{name}_normalised")),
        )
        for name, equation in (("Y", "momentum"), ("W", "velocity"))
    )
    return Section(
        name="conditioning",
        title="Condition and correlation",
        words=tuple(words),
        tables=(
            table_of("Condition numbers", ("regressor", "as it is", "scaled"), rows),
        ),
        charts=charts,
    )


def correlations(result: Result) -> tuple[list[str], np.ndarray]:
    """The base parameters that are determined, and their correlation matrix."""
    C = result.base_covariance
    std = np.sqrt(np.diag(C))
    sure = np.isfinite(std) & (std > 0)
    names = [name for name, one in zip(result.base.names, sure, strict=True) if one]
    return names, (C / np.outer(std, std))[np.ix_(sure, sure)]


def _close(names: list[str], R: np.ndarray) -> str:
    pairs = np.argwhere(np.triu(np.abs(R) > CLOSE, 1))
    if not len(pairs):
        return f"No two base parameters are correlated by more than {CLOSE}."
    order = np.argsort(-np.abs(R[tuple(pairs.T)]))[:LISTED]
    listed = ", ".join(
        f"{names[i]} and {names[j]} ({short(float(R[i, j]))})" for i, j in pairs[order]
    )
    more = " and others" if len(pairs) > LISTED else ""
    return f"Hardly distinguished (correlation): {listed}{more}."
