"""The parameters with their intervals, beside what CAD says of them."""

import numpy as np
from jaxtyping import Int

from orbident.estimation.parameter_table import most_different
from orbident.estimation.quantities import EstimatedSet
from orbident.estimation.result import Result
from orbident.report.charts import listed, shortened
from orbident.report.numbers import (
    NINETY_FIVE,
    interval,
    short,
    signed,
    with_std,
)
from orbident.report.section import Chart, Row, Section, Table

TITLES = {
    "base": "Base parameters: what free floating can identify",
    "phi": "phi: what the velocity of S shows",
    "pi": "pi: what the angular momentum shows",
}

WORDS = (
    "Parameters with their 95 % intervals, and how far they are from {known_as}: in "
    "standard deviations and in percent. A dash: not determined, or the percentage of "
    "a zero. Inertias are about the origins of the bodies' frames.",
)

MOST = 20
"""Rows of a table: a robot with two arms has hundreds of parameters and routes."""

ROUNDING = 1e-4
"""Relative: a chart is at least so much to either side."""

SMALL = 1e-3
"""Of the largest of its kind: beside a CAD value so small, percent say nothing."""


def parameters(result: Result, known_as: str) -> Section | None:
    """The base parameters beside CAD, then all sets; None of a refused result.

    Args:
        result: of an identification.
        known_as: what the nominal values are: `"CAD"`, or `"truth"` in a simulation.
    """
    if result.status == "rejected":
        return None
    base = result.base
    shown = most_different(base, MOST)
    tables = [_table(TITLES["base"], base, known_as, shown, folded=False)]
    words = tuple(text.format(known_as=known_as) for text in WORDS)
    if len(shown) < len(base.names):
        words += (
            f"The first table has the mass and the {len(shown) - 1} parameters that "
            f"differ most from {known_as}; all are below it, folded.",
        )
        tables += [_table("All base parameters", base, known_as)]
    for name in ("phi", "pi"):
        tables += [_table(TITLES[name], getattr(result, name), known_as)]
    return Section(
        name="parameters",
        title="Parameters",
        words=words,
        tables=tuple(table for table in tables if table.rows),
        charts=_chart(base, known_as),
    )


def masses(result: Result, known_as: str) -> Section | None:
    """The mass by every route; None where there is none."""
    found = [row for row in result.mass_forms if np.isfinite(row[2])]
    if not found:
        return None
    every = len(found)
    surest = sorted(row[3] for row in found)[:MOST][-1]
    found = [row for row in found if row[3] <= surest or row[0].startswith("M by")]
    names, _, values, stds = (list(column) for column in zip(*found, strict=True))
    M = float(result.base.nominal[0])
    half = NINETY_FIVE * np.array(stds)
    figure = listed(names, np.array(values), half, M, ROUNDING * M, "M (kg)")
    rows = tuple(
        Row(
            (
                shortened(name),
                with_std(value, std),
                short(std, 2),
                interval(value, std),
            ),
            formula,
        )
        for name, formula, value, std in found
    )
    return Section(
        name="masses",
        title="The mass by every route",
        words=(
            "Every form of Eq. 32, then every method that ran. Where they differ by "
            "more than their intervals, these leave something out: deviations of the "
            "linear routes know white noise only.",
            *([f"The surest of {every}."] if len(found) < every else []),
        ),
        tables=(Table("Mass", ("route", "kg", "± std", "95 %"), rows),),
        charts=(Chart("masses", f"Mass by every route; line: {known_as}", figure),),
    )


def _table(
    title: str,
    found: EstimatedSet,
    known_as: str,
    shown: Int[np.ndarray, " rows"] | None = None,
    folded: bool = True,
) -> Table:
    sigmas, percent = found.sigmas, found.percent
    rows = tuple(
        Row(
            (
                found.names[k],
                with_std(found.values[k], found.std[k]),
                short(found.std[k], 2),
                found.units[k].replace("^2", "²"),
                interval(found.values[k], found.std[k]),
                with_std(found.nominal[k], found.std[k]),
                signed(sigmas[k]),
                signed(percent[k]),
            ),
            found.formulas[k],
        )
        for k in (range(len(found.names)) if shown is None else shown)
    )
    before, after = ("parameter", "estimate", "± std", "unit", "95 %"), ("sigmas", "%")
    return Table(title, (*before, known_as, *after), rows, folded=folded)


def _chart(base: EstimatedSet, known_as: str) -> tuple[Chart, ...]:
    nominal = base.nominal
    kinds = np.array([name.split("_")[0] for name in base.names])
    size = [np.abs(nominal[kinds == kind]).max(initial=0.0) for kind in kinds]
    shown = np.isfinite(base.values) & (np.abs(nominal) > SMALL * np.array(size))
    if not shown.any():
        return ()
    names = [name for name, seen in zip(base.names, shown, strict=True) if seen]
    off = 100 * (base.values[shown] / nominal[shown] - 1)
    half = 100 * NINETY_FIVE * base.std[shown] / np.abs(nominal[shown])
    figure = listed(
        names, off, half, 0.0, 100 * ROUNDING, f"difference from {known_as} (%)"
    )
    return (Chart("base", f"Base parameters beside {known_as}", figure),)
