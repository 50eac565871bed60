"""How an estimate came about: by the steps of a search, or sample by sample."""

import os
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.csv as arrow_csv
from jaxtyping import Float, Int

from orbident.errors import InputError
from orbident.estimation.quantities import UNITS
from orbident.estimation.solution import SMALL, Convergence
from orbident.gaussian import NINETY_FIVE
from orbident.report.charts import (
    BAND,
    LIMIT,
    PREDICTED,
    Panel,
    Trace,
    decades,
    extremes,
    history,
    line,
    stacked,
)
from orbident.report.page import Chart, Section, typeset

WIDE = 10.0
"""Largest over smallest cost, from which on the axis is logarithmic."""


def convergence(steps: Convergence) -> Section | None:
    """Cost and size of every step; None where the method took none."""
    if not steps:
        return None
    cost, size, of = np.array(steps).T
    # Where a round starts there was no step, and its size is NaN.
    number = np.cumsum(~np.isnan(size))
    rounds, taken = [of == each for each in np.unique(of)], int(number[-1])
    words = [
        f"The search took {taken} steps. The cost is the sum of all squared residuals, "
        "each over its noise. By the last step no parameter moved by more than "
        f"{size[-1]:.1g} of its standard deviation; a search ends with a step below "
        f"the line at {SMALL:g}."
    ]
    if len(rounds) > 1:
        words.append(
            f"The {len(rounds)} curves are rounds of the search: before each one the "
            "noise and the weights of outliers are estimated anew, so costs of "
            "different rounds cannot be compared."
        )
    across = [-0.5, taken + 0.5]
    ends = line(np.array(across), np.full(2, SMALL), LIMIT)
    of_cost = [_curve(number[each], cost[each]) for each in rounds]
    of_size = [ends, *(_curve(number[each], size[each]) for each in rounds)]
    # At most nine numbers on the axis.
    x = {"dtick": -(-taken // 8), "range": across}
    wide = cost.max() > WIDE * cost.min()
    costs = Panel("cost", of_cost, y=decades(cost) if wide else {})
    change = "largest change (standard deviations)"
    sizes = Panel(change, of_size, y=decades(size, np.array([SMALL])))
    return Section(
        name="convergence",
        title="Convergence of the fit",
        words=tuple(words),
        charts=(
            Chart("cost", "Cost after each step", stacked([costs], "step", **x), True),
            Chart("steps", "Size of each step", stacked([sizes], "step", **x)),
        ),
    )


def _curve(x: Int[np.ndarray, " n"], y: Float[np.ndarray, " n"]) -> Trace:
    dots = {"mode": "lines+markers", "marker": {"color": PREDICTED, "size": 6}}
    return {**line(x, y, PREDICTED), **dots}


LEARNING = 5
"""The first fifth sets no scale."""

DRAWN = 12
"""Base parameters with a panel of their own: more would be a page each."""


class Trail(NamedTuple):
    """The columns of `history.csv`."""

    names: tuple[str, ...]
    t: Float[np.ndarray, " n"]
    values: Float[np.ndarray, "n beta"]
    std: Float[np.ndarray, "n beta"]
    surprise: Float[np.ndarray, " n"]
    """Squared innovation over what is expected of it."""
    statistic: Float[np.ndarray, " n"]
    """Statistic of the detector of changes, over its threshold."""


def read_trail(path: Path) -> Trail | None:
    """Read a RUN's `history.csv`; None where there is none.

    Raises:
        InputError: it is not what `identify` writes.
    """
    if not path.exists():
        return None
    try:
        # Bytes: as text Arrow takes no name that is not UTF-8.
        with pa.OSFile(os.fsencode(path)) as file:
            table = arrow_csv.read_csv(file)
        column = {
            name: table[name].to_numpy().astype(float) for name in table.column_names
        }
        names = [name for name in column if f"{name}.std" in column]
        return Trail(
            names=tuple(names),
            t=column["t"],
            values=np.column_stack([column[name] for name in names]),
            std=np.column_stack([column[f"{name}.std"] for name in names]),
            surprise=column["innovation_squared"]
            / np.maximum(column["degrees_of_freedom"], 1.0),
            statistic=column["change_statistic"],
        )
    except (pa.ArrowException, OSError, ValueError, KeyError) as error:
        reason = str(error).splitlines()[0]
        raise InputError(
            f"{path}: is not what 'orbident identify' wrote ({reason}); identify again"
        ) from error


def recursion(trail: Trail | None) -> Section | None:
    """Parameters over time with their 95 % bands, and what the detector saw."""
    if trail is None or not np.isfinite(trail.values).all():
        return None
    panels = [
        Panel(
            f"{name} ({typeset(UNITS[name.split('_')[0]])})",
            _course(trail, k),
            y=_y(trail, k),
        )
        for k, name in enumerate(trail.names[:DRAWN])
    ]
    threshold = line(trail.t[[0, -1]], np.ones(2), LIMIT)
    seen = [
        Panel(
            "squared innovation, over what is expected",
            [history(trail.t, trail.surprise, PREDICTED)],
        ),
        Panel(
            "change, over its threshold",
            [history(trail.t, trail.statistic, PREDICTED), threshold],
        ),
    ]
    return Section(
        name="recursion",
        title="Sample by sample",
        words=(
            "The filter starts from CAD values that are 30 % uncertain; bands are "
            "95 %. Where the detector is above its threshold, the robot has probably "
            "changed, and the filter starts again.",
        ),
        charts=(
            Chart("course", "Parameters over time", stacked(panels, "t (s)")),
            Chart(
                "detector",
                "How far samples are from what was expected",
                stacked(seen, "t (s)"),
            ),
        ),
    )


def _course(trail: Trail, k: int) -> list[Trace]:
    shown = extremes(trail.t, trail.values[:, k])
    t, value = trail.t[shown], trail.values[shown, k]
    half = NINETY_FIVE * trail.std[shown, k]
    band = line(
        np.concatenate([t, t[::-1]]),
        np.concatenate([value + half, (value - half)[::-1]]),
        BAND,
        fill="toself",
        fillcolor=BAND,
        line={"width": 0},
        hoverinfo="skip",
    )
    return [band, line(t, value, PREDICTED)]


def _y(trail: Trail, k: int) -> dict[str, list[float]]:
    """What is learnt at first is far off, and would flatten the rest."""
    later = slice(trail.t.size // LEARNING, None)
    # Without a deviation there is no band.
    half = NINETY_FIVE * np.nan_to_num(trail.std[later, k], posinf=0.0)
    value = trail.values[later, k]
    return {"range": [float(np.min(value - half)), float(np.max(value + half))]}
