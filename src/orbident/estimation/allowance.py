"""How much may be worked out: counted in samples, and not in seconds.

So the same recording has the same answer on every machine, however busy that is.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass

import numpy as np


class GivenUpError(Exception):
    """As much has been done as may be."""


@dataclass
class Allowance:
    """What may still be done."""

    left: float = np.inf
    """Samples that may still be gone through, each as often as it is."""
    spent: float = 0.0


_allowed = ContextVar[Allowance | None]("allowed", default=None)

UNKNOWNS = 100
"""So many cost as much as it takes to derive a sample, and its linear equations."""


@contextmanager
def limited_to(allowance: Allowance) -> Iterator[Allowance]:
    """Spend this allowance, and give up where there is nothing left of it.

    Raises:
        GivenUpError: it was given up.
    """
    token = _allowed.set(allowance)
    try:
        yield allowance
    finally:
        _allowed.reset(token)


def spend(samples: int, unknowns: int = UNKNOWNS) -> None:
    """Go through samples, with equations of so many unknowns, or to derive them.

    Raises:
        GivenUpError: more than may be done.
    """
    if allowance := _allowed.get():
        # Equations are eliminated, by the square of their unknowns.
        work = samples * (unknowns / UNKNOWNS) ** 2
        allowance.left -= work
        allowance.spent += work
        if allowance.left < 0:
            raise GivenUpError
