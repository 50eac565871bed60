"""What acts from outside, and tests for it (Wald, 1943)."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.special import chdtri

from orbident.estimation.output_error.problem import Outside
from orbident.estimation.output_error.solver import Prior, Solution

CHANCE = 1e-4
"""Probability that a disturbance is seen in noise alone."""

FREE = 1e3
"""N m or m/s^2: standard deviation beforehand of a disturbance that may exist."""

NONE = 1e-12
"""N m and m/s^2: standard deviation beforehand where there is no disturbance."""


class Push(NamedTuple):
    """A constant torque, or acceleration of the CM, inertial axes."""

    value: Float[np.ndarray, " axes"]
    std: Float[np.ndarray, " axes"]
    believed: bool


def place_of(name: str) -> slice:
    """Where a vector is among the common unknowns."""
    start = 3 * Outside._fields.index(name)
    return slice(start, start + 3)


def freed(prior: Prior, name: str) -> Prior:
    """The prior with nothing known about a disturbance."""
    std = prior.std.copy()
    std[place_of(name)] = FREE
    return prior._replace(std=std)


def push_of(solution: Solution, name: str, axes: tuple[int, ...]) -> Push:
    """What it would be if it were an unknown, and whether that is more than chance."""
    local = solution.linear.local
    step, C = solution.with_prior(freed(solution.prior, name))
    here = local + np.arange(place_of(name).start, place_of(name).stop)[list(axes)]
    value = solution.state.common[here - local] + step[here]
    C = C[np.ix_(here, here)]
    seen = bool(np.diag(C).max() < FREE**2 / 100)
    size = float(value @ np.linalg.solve(C, value))
    believed = seen and size > chdtri(len(axes), CHANCE)
    return Push(value, np.sqrt(np.diag(C)), bool(believed))
