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
class Allowance:
    """What a search may still do."""

    left: float = np.inf
    """Samples that it may still go through; each counts whenever it is."""


_allowed = ContextVar[Allowance | None]("allowance", default=None)


@contextmanager
def limited_to(allowance: Allowance) -> Iterator[None]:
    """Give up what is tried when the allowance is at its end.

    Args:
        allowance: is spent.

    Raises:
        GivenUpError: it was given up.
    """
    token = _allowed.set(allowance)
    try:
        yield
    finally:
        _allowed.reset(token)


def spend(problem: MomentumProblem, times: float = 1.0) -> None:
    """Go through all samples.

    Args:
        problem: of a recording.
        times: how often.

    Raises:
        GivenUpError: more than may be done.
    """
    allowance = _allowed.get()
    if allowance is None:
        return
    allowance.left -= times * problem.samples.t.size
    if allowance.left < 0:
        raise GivenUpError
