"""Estimated parameters beside CAD, as lines of text: all, or those that differ most."""

from collections.abc import Iterable, Iterator

import numpy as np
from jaxtyping import Int

from orbident.data_table import Interval, Numeric, TableRow
from orbident.estimation.quantities import EstimatedSet
from orbident.files.names import counted

MOST = 9
"""Parameters that fit, with what stands around them, a terminal of 24 lines."""

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
    """Rows of the parameters with these numbers; the note is the formula.

    Cells are the name, estimate, deviation, unit, 95 %, CAD, sigmas and percent.
    """
    units, sigmas, percent = found.units, found.sigmas, found.percent
    for k in which:
        cells = (
            found.names[k],
            Numeric(found.values[k], ".6g", found.std[k]),
            Numeric(found.std[k], ".2g"),
            units[k],
            Interval(found.values[k], found.std[k]),
            Numeric(found.nominal[k], ".6g", found.std[k]),
            Numeric(sigmas[k], "+.1f" if abs(sigmas[k]) < 1000 else "+.1e"),
            Numeric(percent[k], "+.2g"),
        )
        yield TableRow(cells, found.formulas[k])


def short_table(found: EstimatedSet) -> list[str]:
    """Lines of at most `MOST` parameters, and how far the others are from CAD."""
    shown = most_different(found, MOST)
    lines = [HEAD, *map(parameter_line, parameter_rows(found, shown.tolist()))]
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


def parameter_line(row: TableRow) -> str:
    """A row as text, without its note."""
    name, value, std, unit, _, nominal, sigmas, percent = map(str, row.cells)
    numbers = f"{value:>12} {std:>9} {nominal:>12} {sigmas:>8} {percent:>8}"
    return f"  {name:10} {numbers}  {unit}"
