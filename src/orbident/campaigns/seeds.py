"""The same run with one seed after another."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError


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
        """Of the seed with the largest error, unsigned."""
        return np.max(np.abs(self.runs), axis=0)


def over_seeds(
    run: Callable[[int], Float[np.ndarray, " quantities"]],
    seeds: int,
    first: int = 0,
    progress: Callable[[float], object] = lambda _: None,
) -> Errors:
    """Run once for each of `first, first + 1, ...`.

    Args:
        run: from a seed to the errors of one run.
        seeds: how many, one or more.
        first: the first seed.
        progress: is called with the fraction done.

    Raises:
        InputError: there are no seeds.
    """
    if seeds < 1:
        raise InputError(f"seeds: found {seeds}; give one or more")
    rows = []
    for k in range(seeds):
        progress(k / seeds)
        rows.append(run(first + k))
    return Errors(np.array(rows))
