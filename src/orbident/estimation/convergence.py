"""How a search converged: its cost, and its steps, which become small."""

from typing import NamedTuple

SMALL = 1e-2
"""Standard deviations: a search ends with a step that is smaller than this."""


class Step(NamedTuple):
    """One step of a search."""

    cost: float
    """After the step: the sum of the squares of all whitened residuals and priors."""
    size: float
    """How far the step led, in standard deviations of the parameters: none moved by
    more of its own. NaN where a round starts."""
    round: int = 1
    """Each round weighs residuals by the noise and outliers that the one before it
    showed, so costs of different rounds cannot be compared."""


Convergence = tuple[Step, ...]
"""All steps of a search, in order; none for a method that solves its equations once."""
