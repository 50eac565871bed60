"""The parameters with their intervals, beside what CAD says of them."""

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float

from orbident.estimation.quantities import Parameters
from orbident.estimation.result import Result
from orbident.model.minimal_sets import minimal_sets
from orbident.report.charts import listed, shortened
from orbident.report.numbers import (
    NINETY_FIVE,
    interval,
    percent,
    short,
    with_std,
)
from orbident.report.section import Chart, Row, Section, Table

Nominal = Mapping[str, Float[np.ndarray, " n"]]

TITLES = {
    "base": "Base parameters: M, kg; sigma, kg m; iota, kg m²",
    "phi": "phi, m: what the velocity of S shows",
    "pi": "pi, kg m²: what the angular momentum shows",
}

MOST = 20
"""Routes to the mass: a robot with two arms has hundreds."""

ROUNDING = 1e-4
"""Relative: a chart is at least so much to either side."""

SMALL = 1e-3
"""Of the largest of its kind: beside a CAD value so small, percent say nothing."""


def nominal_of(result: Result) -> Nominal:
    """All sets of the robot's own inertia; NaN where a result has other sets."""
    robot = result.robot
    sets = minimal_sets(robot)
    found = {
        "base": sets.beta(robot.theta),
        "phi": sets.phi(robot.theta),
        "pi": sets.pi(robot.theta),
    }
    sizes = {name: getattr(result, name).values.size for name in found}
    return {
        name: values if values.size == sizes[name] else np.full(sizes[name], np.nan)
        for name, values in found.items()
    }


def parameters(result: Result, nominal: Nominal, known_as: str) -> Section:
    """All sets as tables, and how far the base parameters are from CAD.

    Args:
        result: of an identification.
        nominal: `nominal_of` it.
        known_as: what the nominal values are: `"CAD"`, or `"truth"` in a simulation.
    """
    tables = [
        _table(title, getattr(result, name), nominal[name], known_as)
        for name, title in TITLES.items()
    ]
    charts = _chart(result.base, nominal["base"], known_as)
    return Section(
        name="parameters",
        title="Parameters",
        words=(
            "Parameters with their 95 % intervals; a dash is what the recording does "
            "not tell. Inertias are about the origins of the bodies' frames, products "
            "of sigma as the formulas have them.",
        ),
        tables=tuple(table for table in tables if table.rows),
        charts=charts,
    )


def masses(result: Result, nominal: Nominal, known_as: str) -> Section | None:
    """The mass by every route; None where there is none."""
    found = [row for row in result.mass_forms if np.isfinite(row[2])]
    if not found:
        return None
    every = len(found)
    surest = sorted(row[3] for row in found)[:MOST][-1]
    found = [row for row in found if row[3] <= surest or row[0].startswith("M by")]
    names, _, values, stds = (list(column) for column in zip(*found, strict=True))
    M = float(nominal["base"][0])
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
    title: str, found: Parameters, nominal: Float[np.ndarray, " n"], known_as: str
) -> Table:
    rows = tuple(
        Row(
            (
                name,
                with_std(value, std),
                short(std, 2),
                interval(value, std),
                with_std(float(cad), std),
                percent(_off(value, float(cad))),
            ),
            formula,
        )
        for (name, formula, value, std), cad in zip(found, nominal, strict=True)
    )
    head = ("parameter", "estimate", "± std", "95 %", known_as, "difference (%)")
    return Table(title, head, rows)


def _off(value: float, cad: float) -> float:
    return value / cad - 1 if cad else np.nan


def _chart(
    base: Parameters, nominal: Float[np.ndarray, " n"], known_as: str
) -> tuple[Chart, ...]:
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
