"""Estimated parameters beside CAD, as lines of text: all, or those that differ most."""

from collections.abc import Iterable, Iterator

import numpy as np
from jaxtyping import Int

from orbident.data_table import Interval, Numeric, TableRow
from orbident.estimation.quantities import EstimatedSet, MassRoutes
from orbident.files.names import counted

MOST = 12
"""Parameters that fit, with what stands around them, a terminal of 24 lines."""

COLUMNS = "parameter", "estimate", "± std", "unit", "95 %", "CAD", "sigmas", "%"

FAR = 3.0
"""Sigmas from CAD that are no chance: the row is marked."""

HEAD = f"  {'':10} {'estimate':>12} {'std':>9} {'CAD':>12} {'sigmas':>8} {'%':>8}"
"""`sigmas` and `%`: the difference from CAD in standard deviations, and in percent."""


def most_different(found: EstimatedSet, most: int) -> Int[np.ndarray, " rows"]:
    """Which parameters to show where not all can be.

    Args:
        found: a set whose first parameter is always shown, as the total mass is.
        most: so many parameters at most.

    Returns:
        All in their order where they are few enough; else the first, and after it those
        that differ from CAD by the most standard deviations, the furthest first.
    """
    if len(found.names) <= most:
        return np.arange(len(found.names))
    off = np.nan_to_num(np.abs(found.sigmas), nan=-1.0)
    order = 1 + np.argsort(-off[1:], kind="stable")
    return np.concatenate([[0], order[: most - 1]])


def parameter_rows(found: EstimatedSet, which: Iterable[int]) -> Iterator[TableRow]:
    """Rows of a table, with the columns of `COLUMNS` and the formula as a note.

    Args:
        found: a set.
        which: parameters of it, by their numbers.
    """
    units, sigmas, percent = found.units, found.sigmas, found.percent
    for k in which:
        std = float(found.std[k])
        cells = (
            found.names[k],
            Numeric(float(found.values[k]), ".6g", std),
            Numeric(std, ".2g"),
            units[k],
            Interval(float(found.values[k]), std),
            Numeric(float(found.nominal[k]), ".6g", std),
            Numeric(float(sigmas[k]), "+.1f" if abs(sigmas[k]) < 1000 else "+.1e"),
            Numeric(float(percent[k]), "+.2g"),
        )
        yield TableRow(cells, found.formulas[k], bool(abs(sigmas[k]) > FAR))


def short_table(found: EstimatedSet) -> list[str]:
    """Lines of at most `MOST` parameters, and how far the others are from CAD."""
    shown = most_different(found, MOST)
    lines = [HEAD, *map(_line, parameter_rows(found, shown.tolist()))]
    left = np.setdiff1d(np.arange(len(found.names)), shown)
    off = np.abs(found.sigmas[left])
    near, lost = np.isfinite(off), np.isnan(found.values[left])
    words = []
    if near.any():
        many = counted(int(near.sum()), "more is", "more are")
        words.append(f"{many} within {off[near].max():.2g} sigmas of CAD")
    if lost.any():
        many = counted(int(lost.sum()), "more is", "more are")
        words.append(f"{many} not determined")
    return [*lines, f"  {', '.join(words)}"] if words else lines


def whole_table(found: EstimatedSet) -> list[str]:
    """All parameters, with their formulas."""
    rows = parameter_rows(found, range(len(found.names)))
    return [HEAD, *(f"{_line(row):75} {row.note}" for row in rows)]


def mass_rows(routes: MassRoutes, which: Iterable[int]) -> Iterator[TableRow]:
    """Route, mass, deviation, 95 % and sigmas; the note is the formula.

    Args:
        routes: to the mass.
        which: of them, by their numbers.
    """
    for k in which:
        value, std = float(routes.values[k]), float(routes.std[k])
        cells = (
            *(routes.names[k], Numeric(value, ".6g", std), Numeric(std, ".2g")),
            *(Interval(value, std), Numeric(float(routes.sigmas[k]), "+.1f")),
        )
        yield TableRow(cells, routes.formulas[k])


def routes_left_out(routes: MassRoutes) -> list[str]:
    """How many forms of Eq. 32 are not shown, if any, and why."""
    if not routes.left_out:
        return []
    return [
        f"{routes.left_out} forms of Eq. 32 give no mass: their deviations are beyond "
        "a tenth of it"
    ]


def _line(row: TableRow) -> str:
    name, value, std, unit, _, nominal, sigmas, percent = map(str, row.cells)
    numbers = f"{value:>12} {std:>9} {nominal:>12} {sigmas:>8} {percent:>8}"
    return f"  {name:10} {numbers}  {unit}"
