"""Repeats a study's run with many seeds of its noise, here or in worker processes."""

from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass, fields
from functools import partial
from typing import Any, NamedTuple

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


@dataclass(frozen=True)
class StudyRuns:
    """How a study was made."""

    seeds: int
    rejected: int
    """Seeds of which something was refused, or could not be found."""
    elapsed_s: float

    @property
    def counts(self) -> dict[str, Any]:
        """As `study --json` gives them."""
        return {each.name: getattr(self, each.name) for each in fields(StudyRuns)}


class Series(NamedTuple):
    """One run a seed."""

    run: Callable[[int], Any]
    """What a seed's run makes; it is sent to the workers."""
    seeds: range
    row_of: Callable[[Any], Row] = np.asarray
    """The errors of what a run has made; it is sent there too."""
    made: tuple[Any, ...] = ()
    """What the runs of the first seeds have made, where they are made already."""


@one_thread
def _rows(
    runs: tuple[tuple[Callable[[int], Any], Callable[[Any], Row]], ...],
    task: tuple[int, range],
) -> list[Row]:
    k, seeds = task
    run, row_of = runs[k]
    return [row_of(run(seed)) for seed in seeds]


class SeedRuns(NamedTuple):
    """Which runs of a study are made, and where."""

    seeds: int = 1
    """How many runs, one a seed."""
    first: int = 0
    """The first of the seeds."""
    progress: Callable[[float], object] = lambda _: None
    """Is called with the fraction done."""
    executors: Executors = InThisProcess
    """Where all runs but the first are made."""

    @property
    def numbers(self) -> range:
        """All seeds."""
        return range(self.first, self.first + self.seeds)

    def over(self, *series: Series) -> list[Errors]:
        """The errors of each series, the same wherever and in whatever order runs are.

        A series has the same number of quantities in all its runs.

        Raises:
            InputError: a series has no seeds, or workers die again and again.
            Exception: whatever a run raises.
        """
        for each in series:
            if not each.seeds:
                raise InputError("seeds: found 0; give one or more")
        rows = [dict(zip(e.seeds, map(e.row_of, e.made), strict=False)) for e in series]
        tasks = []
        for k, each in enumerate(series):
            left = each.seeds[len(each.made) :]
            size = min(MOST, -(-len(left) // MOST)) or 1
            tasks += [(k, left[at : at + size]) for at in range(0, len(left), size)]
        runs = tuple((each.run, each.row_of) for each in series)
        made, count = 0, sum(len(part) for _, part in tasks)
        with closing(computed(self.executors, partial(_rows, runs), tasks)) as done:
            for (k, part), future in done:
                rows[k] |= zip(part, future.result(), strict=True)
                made += len(part)
                self.progress(made / count)
        return [
            Errors(np.array([found[seed] for seed in each.seeds]))
            for each, found in zip(series, rows, strict=True)
        ]


ONE_RUN = SeedRuns()
"""The first seed alone."""
