"""What the clocks of computers and networks do to the times of rows."""

import numpy as np
from mistake import Groups, twice
from recordings import SEED
from wrong_columns import Change, stamped


def jittered(size: float) -> Change:
    """A row is stamped up to so much after its samples were taken, s."""

    def change(t: np.ndarray) -> np.ndarray:
        return t + size * np.random.default_rng(SEED).random(t.size)

    return change


def set_once(step: float) -> Change:
    """The clock is set forward in mid-run, s."""
    return lambda t: t + step * (np.arange(t.size) >= t.size // 2)


ON_TIMES: Groups = {
    "time": (
        *twice("rows stamped up to {:g} s late, each for itself",
               lambda size: stamped(jittered(size)), 1e-3, 1e-2,
               cause="time|clock|row jitter|uneven*|spread|late|noise"),
        *twice("clock of all set forward by {:g} s",
               lambda size: stamped(set_once(size)), 5e-3, 5e-2,
               cause="time|clock|row gap|lost|missing|set|jump*|late"),
    ),
}  # fmt: skip
