"""Many starts: from random motions inside the limits to the best local optimum."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.excitation.descent import Found, Function, descend
from orbident.excitation.polytope import Polytope
from orbident.excitation.problem import Problem, value_and_gradient

MOST_HALVINGS = 20
FIRST_MU, FIRST_P = 1e-2, 2.0


class Progress(NamedTuple):
    """How far a search has come."""

    fraction: float
    best: float
    """The criterion."""
    starts: int


@dataclass(frozen=True)
class Effort:
    """How long to search: so many starts, or until so many seconds have passed."""

    starts: int | None
    budget: float | None
    """Seconds."""

    def fraction(self, starts: int, seconds: float) -> float:
        """Done so far, 1 where the search is to end."""
        if self.budget is not None:
            return min(seconds / self.budget, 1.0)
        return starts / (self.starts or 1)


class Searched(NamedTuple):
    """The outcome of a search."""

    y: Float[np.ndarray, "joints m"]
    value: float
    """Logarithm of the criterion on the search's grid."""
    first_values: tuple[float, ...]
    """Of each random start, before descent."""
    values: tuple[float, ...]
    """Of each, after it."""
    evaluations: int


def search(
    problem: Problem,
    polytope: Polytope,
    middle: Float[np.ndarray, "joints m"],
    effort: Effort,
    seed: int,
    report: Callable[[Progress], object],
) -> Searched:
    """The best of many descents; an interrupt ends the search, and keeps the best.

    The n-th start depends on the seed and n alone.

    Args:
        problem: what is minimised.
        polytope: the joint limits.
        middle: a motion inside them.
        effort: when to end.
        seed: of the random starts.
        report: is called after each start.

    Raises:
        InputError: the limits of the base leave no room even for the gentlest motion.
    """
    started = time.perf_counter()
    best, found, first_values = Found(middle, np.inf, 0), [], []

    def function(
        y: Float[np.ndarray, "joints m"], p: float, mu: float
    ) -> tuple[float, float, Float[np.ndarray, "joints m"]]:
        nonlocal best
        smooth, exact, gradient = value_and_gradient(y, problem, p, mu)
        if np.isfinite(smooth) and exact < best.value:
            best = Found(y, exact, 0)
        return smooth, exact, gradient

    def stopping() -> bool:
        seconds = time.perf_counter() - started
        return effort.budget is not None and seconds > effort.budget

    try:
        fraction = 0.0
        while fraction < 1:
            random = np.random.default_rng([seed, len(found)])
            y, first = _random_start(function, polytope, middle, random)
            first_values.append(first)
            found.append(descend(function, polytope, y, stopping))
            fraction = effort.fraction(len(found), time.perf_counter() - started)
            report(Progress(fraction, float(np.exp(best.value)), len(found)))
    except KeyboardInterrupt:
        # Without a first start there is nothing to keep.
        if not first_values:
            raise
    return Searched(
        y=best.y,
        value=best.value,
        first_values=tuple(first_values),
        values=tuple(each.value for each in found),
        evaluations=sum(each.evaluations for each in found),
    )


def _random_start(
    function: Function,
    polytope: Polytope,
    middle: Float[np.ndarray, "joints m"],
    random: np.random.Generator,
) -> tuple[Float[np.ndarray, "joints m"], float]:
    """A motion in a random direction, as large as joints and base allow, nearly."""
    direction = random.standard_normal(middle.shape)
    share = random.uniform(0.5, 0.95, len(middle))
    y = middle + (share * polytope.reach(middle, direction))[:, None] * direction
    for _ in range(MOST_HALVINGS):
        smooth, exact, gradient = function(y, FIRST_P, FIRST_MU)
        if np.isfinite(smooth) and np.isfinite(gradient).all():
            return y, exact
        y = middle + (y - middle) / 2
    raise InputError(
        "base limits: even the gentlest joint motion exceeds the limit of base rate, "
        "excursion or wheel speed; raise them, or start with less momentum"
    )
