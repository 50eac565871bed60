"""How much a search for causes may do: counted in samples, and not in seconds.

So the same recording gets the same answer on every machine, however busy that is.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass

import numpy as np

from orbident.estimation.momentum_problem import MomentumProblem


class GivenUpError(Exception):
    """A search has done as much as it may, in the middle of a trial."""


@dataclass
class Effort:
    """What a search may still do."""

    left: float = np.inf
    """Samples that it may still go through; each counts whenever it is."""


_effort = ContextVar[Effort | None]("effort", default=None)


@contextmanager
def limited_to(effort: Effort) -> Iterator[None]:
    """Give up what is tried when the effort is at its end.

    Args:
        effort: is spent.

    Raises:
        GivenUpError: it was given up.
    """
    token = _effort.set(effort)
    try:
        yield
    finally:
        _effort.reset(token)


def spend(problem: MomentumProblem, times: float = 1.0) -> None:
    """Go through all samples.

    Args:
        problem: of a recording.
        times: how often.

    Raises:
        GivenUpError: more than may be done.
    """
    effort = _effort.get()
    if effort is None:
        return
    effort.left -= times * problem.samples.t.size
    if effort.left < 0:
        raise GivenUpError
