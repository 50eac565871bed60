"""Times that were kept as float32, which has a step of 1/16 s after a week."""

import numpy as np
from jaxtyping import Float

MATTERS = 1e-3
"""Of the time from row to row: a wheel of 100 rad/s turns 1 mrad in 1e-4 of 0.1 s."""

SEEN = 100_000
"""Times that are looked at: the first ones tell it."""

UNEVEN = 0.1
"""Part of the steps that differ: those that a float32 holds exactly are all alike."""


def float32_step(t: Float[np.ndarray, " samples"]) -> float:
    """What times were rounded to as float32, s; 0 where they were not, or hardly.

    Args:
        t: times, s, in any order.
    """
    t = t[:SEEN]
    if not np.array_equal(t, t.astype(np.float32)):
        return 0.0
    step, steps = float(np.spacing(np.float32(np.abs(t).max()))), np.diff(t)
    uneven = np.mean(steps != np.median(steps)) > UNEVEN
    return step if uneven and step > MATTERS * np.mean(np.abs(steps)) else 0.0
