"""Torque and pull from outside, and whether there is any (Wald, 1943)."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.stats import chi2

from orbident.estimation.output_error.solve import Prior, Solution
from orbident.estimation.output_error.unknowns import LOCAL, Own

CHANCE = 1e-4
"""Of finding one in noise."""

FREE = 1e3
"""N m or m/s^2, beforehand, where there may be one."""


class Push(NamedTuple):
    """A constant torque, or acceleration of the CM, inertial axes."""

    value: Float[np.ndarray, " axes"]
    std: Float[np.ndarray, " axes"]
    believed: bool


def place_of(name: str) -> slice:
    """Where a vector is among the common unknowns."""
    start = 3 * Own._fields.index(name) - LOCAL
    return slice(start, start + 3)


def freed(prior: Prior, name: str) -> Prior:
    """With nothing known about it."""
    std = prior.std.copy()
    std[place_of(name)] = FREE
    return prior._replace(std=std)


def push_of(solution: Solution, name: str, axes: tuple[int, ...]) -> Push:
    """What it would be if it were an unknown, and whether that is more than chance."""
    chain = solution.linear.known.chain
    step, C = solution.with_prior(freed(solution.prior, name))
    here = chain + np.arange(place_of(name).start, place_of(name).stop)[list(axes)]
    value = solution.state.common[here - chain] + step[here]
    C = C[np.ix_(here, here)]
    seen = bool(np.diag(C).max() < FREE**2 / 100)
    size = float(value @ np.linalg.solve(C, value))
    believed = seen and size > chi2.isf(CHANCE, len(axes))
    return Push(value, np.sqrt(np.diag(C)), bool(believed))
