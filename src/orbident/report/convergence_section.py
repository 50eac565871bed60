"""How the search for the estimate converged."""

from collections.abc import Sequence
from itertools import groupby
from operator import attrgetter
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.estimation.solution import SMALL, Convergence
from orbident.report.charts import (
    LIMIT,
    PREDICTED,
    Panel,
    Trace,
    decades,
    line,
    stacked,
)
from orbident.report.page import Chart, Section

COST = "cost"
SIZE = "largest change (standard deviations)"

WIDE = 10.0
"""Largest over smallest cost, from which on the axis is logarithmic."""


class Round(NamedTuple):
    """What is drawn of one round of a search."""

    number: Float[np.ndarray, " n"]
    """How many steps were taken by then, in all rounds together."""
    cost: Float[np.ndarray, " n"]
    size: Float[np.ndarray, " n"]
    """NaN where a round starts."""


def rounds(steps: Convergence) -> list[Round]:
    """The steps of each round, in order."""
    found, taken = [], 0
    for _, each in groupby(steps, attrgetter("round")):
        cost, size, _ = np.array(list(each)).T
        number = taken + np.cumsum(~np.isnan(size))
        found.append(Round(number.astype(float), cost, size))
        taken = int(number[-1])
    return found


def is_wide(every: Sequence[Round]) -> bool:
    """Whether costs of a search differ by more than a linear axis shows."""
    cost = np.concatenate([each.cost for each in every])
    return bool(cost.max() > WIDE * cost.min())


def spacing(taken: int) -> int:
    """Steps from one number on the axis to the next: at most nine numbers."""
    return -(-taken // 8)


def convergence(steps: Convergence) -> Section | None:
    """Cost and size of every step; None where the method took none."""
    if not steps:
        return None
    every = rounds(steps)
    cost, size = (np.concatenate(y) for y in list(zip(*every, strict=True))[1:])
    last, taken = steps[-1], int(every[-1].number[-1])
    words = [
        f"The search took {taken} steps. The cost is the sum of all squared residuals, "
        "each over its noise. By the last step no parameter moved by more than "
        f"{last.size:.1g} of its standard deviation; a search ends with a step below "
        f"the line at {SMALL:g}."
    ]
    if len(every) > 1:
        words.append(
            f"The {len(every)} curves are rounds of the search: before each one the "
            "noise and the weights of outliers are estimated anew, so costs of "
            "different rounds cannot be compared."
        )
    across = [-0.5, taken + 0.5]
    ends = line(np.array(across), np.full(2, SMALL), LIMIT)
    of_cost = [_curve(each.number, each.cost) for each in every]
    of_size = [ends, *(_curve(each.number, each.size) for each in every)]
    x = {"dtick": spacing(taken), "range": across}
    return Section(
        name="convergence",
        title="Convergence of the fit",
        words=tuple(words),
        charts=(
            Chart(
                "cost",
                "Cost after each step",
                stacked(
                    [Panel(COST, of_cost, y=decades(cost) if is_wide(every) else {})],
                    "step",
                    **x,
                ),
                first=True,
            ),
            Chart(
                "steps",
                "Size of each step",
                stacked(
                    [Panel(SIZE, of_size, y=decades(size, np.array([SMALL])))],
                    "step",
                    **x,
                ),
            ),
        ),
    )


def _curve(x: Float[np.ndarray, " n"], y: Float[np.ndarray, " n"]) -> Trace:
    dots = {"mode": "lines+markers", "marker": {"color": PREDICTED, "size": 6}}
    return {**line(x, y, PREDICTED), **dots}
