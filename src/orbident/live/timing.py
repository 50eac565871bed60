"""Which times of a stream to believe: a lone one far from its neighbours is wrong.

A time that is wrong and far ahead would make every later sample late. One that is more
than `GAP` from the one before is therefore believed only when the next one follows it.
"""

from enum import Enum
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

GAP = 10.0
"""s: samples that are further apart are those of an interruption, or of another clock;
networks delay packets by less."""


class Leap(Enum):
    """How a time is far from the one before."""

    waits = "the next sample will tell"
    alone = "wrong"
    forward = "samples are lacking"
    back = "the clock was set back"


class Run(NamedTuple):
    """Samples that follow each other, and what comes behind them."""

    size: int
    leap: Leap | None
    """What the sample behind them is; None where there is none."""


def next_run(before: float, t: Float[np.ndarray, " n"]) -> Run:
    """How many samples follow the one before, and how the next one does not.

    Args:
        before: time of the sample before, s; NaN if there is none.
        t: all times that wait, s; none is NaN.
    """
    far = np.flatnonzero(np.abs(np.diff(t, prepend=before)) > GAP)
    if not far.size:
        return Run(t.size, None)
    at = int(far[0])
    if at + 1 == t.size:
        return Run(at, Leap.waits)
    if not abs(t[at + 1] - t[at]) <= GAP:
        return Run(at, Leap.alone)
    last = t[at - 1] if at else before
    return Run(at, Leap.forward if t[at] > last else Leap.back)
