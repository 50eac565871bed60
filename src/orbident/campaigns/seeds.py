"""Repeats a study's run with many seeds of its noise, here or in worker processes."""

from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.campaigns.executors import Executors, InThisProcess, computed
from orbident.errors import InputError
from orbident.threads import one_thread

MOST = 8
"""Seeds that are given to a worker at once: what a robot's formulas are is worked out
once for them. Of up to as many seeds each goes by itself."""

Row = Float[np.ndarray, " quantities"]


@dataclass(frozen=True)
class Errors:
    """Errors of some quantities, a row a seed; NaN where a run had no value."""

    runs: Float[np.ndarray, "seeds quantities"]

    @property
    def rms(self) -> Float[np.ndarray, " quantities"]:
        """Root mean square over the seeds; NaN where a run had none."""
        return np.sqrt(np.mean(self.runs**2, axis=0))

    @property
    def worst(self) -> Float[np.ndarray, " quantities"]:
        """The largest error of any seed, unsigned."""
        return np.max(np.abs(self.runs), axis=0)


class Series(NamedTuple):
    """One run a seed."""

    run: Callable[[int], Row]
    """Function from a seed to the errors of one run; it is sent to the workers."""
    seeds: range
    known: tuple[Row, ...] = ()
    """The errors of the first seeds, where they are known already."""


def over_seeds(
    series: Sequence[Series],
    executors: Executors = InThisProcess,
    progress: Callable[[float], object] = lambda _: None,
) -> list[Errors]:
    """Make all runs; the same numbers wherever and in whatever order.

    Args:
        series: each with the same number of quantities in all its runs.
        executors: where runs are made.
        progress: is called with the fraction done.

    Returns:
        The errors of each series.

    Raises:
        InputError: a series has no seeds, or workers die again and again.
        Exception: whatever a run raises.
    """
    for each in series:
        check_seeds(len(each.seeds))
    rows = [dict(zip(each.seeds, each.known, strict=False)) for each in series]
    tasks = [
        (k, part)
        for k, each in enumerate(series)
        for part in _parts(each.seeds[len(each.known) :])
    ]
    runs = tuple(each.run for each in series)
    made, count = 0, sum(len(part) for _, part in tasks)
    with closing(computed(executors, partial(_rows, runs), tasks)) as done:
        for (k, part), future in done:
            rows[k] |= zip(part, future.result(), strict=True)
            made += len(part)
            progress(made / count)
    return [
        Errors(np.array([found[seed] for seed in each.seeds]))
        for each, found in zip(series, rows, strict=True)
    ]


def check_seeds(seeds: int) -> None:
    """Refuses none.

    Raises:
        InputError: There are no seeds.
    """
    if seeds < 1:
        raise InputError(f"seeds: found {seeds}; give one or more")


def _parts(seeds: range) -> list[range]:
    size = min(MOST, -(-len(seeds) // MOST)) or 1
    return [seeds[k : k + size] for k in range(0, len(seeds), size)]


@one_thread
def _rows(runs: tuple[Callable[[int], Row], ...], task: tuple[int, range]) -> list[Row]:
    k, seeds = task
    return [runs[k](seed) for seed in seeds]
