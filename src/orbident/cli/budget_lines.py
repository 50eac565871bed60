"""What deviations are made of, for the terminal."""

from collections.abc import Iterator
from textwrap import wrap
from typing import Any

from orbident.data_table import DataTable

COLUMNS = 80
"""Of a terminal, as it opens nearly everywhere."""


def limits(budget: Any) -> list[str]:
    """What limits the mass, and what would halve its deviation.

    Args:
        budget: of a result; None where it has none.
    """
    return [] if budget is None else wrap(budget.in_words(), COLUMNS)


def budget_lines(budget: Any) -> Iterator[str | DataTable]:
    """The same, below what every variance is made of."""
    if budget is None:
        return
    yield from ("", budget.table(), "", *limits(budget))
