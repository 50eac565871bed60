"""Estimated parameters beside CAD, as lines of text: all, or those that differ most."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Int

from orbident.estimation.quantities import EstimatedSet
from orbident.files.names import counted

MOST = 12
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


def short_table(found: EstimatedSet) -> list[str]:
    """Lines of at most `MOST` parameters, and how far the others are from CAD."""
    shown = most_different(found, MOST)
    lines = [HEAD, *_rows(found, shown.tolist())]
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
    rows = _rows(found, range(len(found.names)))
    both = zip(rows, found.formulas, strict=True)
    return [HEAD, *(f"{row:75} {formula}" for row, formula in both)]


def _rows(found: EstimatedSet, which: Sequence[int]) -> list[str]:
    units, sigmas, percent = found.units, found.sigmas, found.percent
    return [
        f"  {found.names[k]:10} {number(found.values[k], '.6g'):>12} "
        f"{number(found.std[k], '.2g'):>9} {number(found.nominal[k], '.6g'):>12} "
        f"{_sigmas(sigmas[k]):>8} {number(percent[k], '+.2g'):>8}  {units[k]}"
        for k in which
    ]


def number(value: float, form: str) -> str:
    """A number in this format; a dash for NaN."""
    return f"{value:{form}}" if value == value else "-"


def _sigmas(value: float) -> str:
    return number(value, "+.1f" if abs(value) < 1000 else "+.1e")
