"""Many starts: from random motions inside the limits to the best local optima.

Each start is sequential quadratic programming (SLSQP of SciPy) with exact gradients.
The joints' limits are linear in the coordinates of a motion. Half of the starts after
the first few begin beside a good motion that was found already: what is best is often a
small step from what is good.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.optimize import minimize

from orbident.errors import InputError
from orbident.excitation.joint_limits import Polytope
from orbident.excitation.problem import Problem, Tried

POWERS = (2.0, 128.0)
"""Of the means that stand for extreme eigenvalues: first smooth, then close to them."""

LAST_POWER = 512.0
"""When the best are descended once more, under limits at all nodes."""

POLISHED = 3
"""So many of the best are."""

SEARCHING = 0.9
"""Share of a budget after which only the best are descended once more."""

NEAR = 0.1
"""Of a limit: the last descents keep to the limits that are nearer than this."""

FIRST_RANDOM = 8
"""So many starts are random, then every second one."""

BEST = 6
"""A start beside a good motion takes one of so many."""

SHARES = 0.5, 0.95
"""A random motion takes a share between these of what the joints' limits allow."""

ASIDE = 0.5
"""How far beside, in coordinates with rates of unit mean square over their limits."""

INWARD = 0.9
"""Share of a good motion's amplitude that such a start keeps: limits are then free."""

TOLERANCE = 1e-4
"""Of the criterion's logarithm; what ends a start."""

MOST_STEPS = 100
MOST_HALVINGS = 20

OUTSIDE = 1e-6
"""Of a limit: rounding in SLSQP's steps, and far less than limits are kept back."""

ALIKE = 1e-3
"""Optima whose criterion's logarithms differ by less are taken for the same."""


class Progress(NamedTuple):
    """How far a search has come."""

    fraction: float
    best: float
    """The criterion."""
    starts: int


@dataclass(frozen=True)
class Effort:
    """How long to search: so many starts, or until a moment."""

    starts: int | None
    budget: float | None
    """Seconds."""
    began: float = field(default_factory=time.perf_counter)

    def fraction(self, starts: int) -> float:
        """Share of the starts that is done, 1 where no other is to begin."""
        if self.budget is not None:
            return min(self._used(self.budget) / SEARCHING, 1.0)
        return starts / (self.starts or 1)

    def over(self, share: float) -> bool:
        """Whether so much of the time is up."""
        return self.budget is not None and self._used(self.budget) >= share

    def _used(self, budget: float) -> float:
        return (time.perf_counter() - self.began) / budget


class Found(NamedTuple):
    """A motion inside the limits."""

    value: float
    """Logarithm of the criterion, on the search's grid."""
    y: Float[np.ndarray, "joints m"]


@dataclass
class Searched:
    """What a search has found so far."""

    random: list[Found] = field(default_factory=list)
    """Random motions, before any descent."""
    optima: list[Found] = field(default_factory=list)
    """The best first; nearly equal ones once."""
    starts: int = 0
    evaluations: int = 0
    interrupted: bool = False

    @property
    def best(self) -> Found:
        """The least value of all."""
        return min([*self.optima, *self.random], key=lambda found: found.value)

    def keep(self, found: Found) -> None:
        """Adds an optimum in its place."""
        near = [each for each in self.optima if abs(each.value - found.value) < ALIKE]
        if any(each.value <= found.value for each in near):
            return
        # Of two that are alike, the better.
        self.optima = sorted(
            [*(each for each in self.optima if each not in near), found],
            key=lambda each: each.value,
        )


class _TimeIsUpError(Exception):
    """Ends a descent."""


def search(
    problem: Problem,
    polytopes: tuple[Polytope, Polytope],
    middle: Float[np.ndarray, "joints m"],
    effort: Effort,
    seed: int,
    report: Callable[[Progress], object],
) -> Searched:
    """Descend from many starts; an interrupt ends the search, and keeps what it found.

    Args:
        problem: what is minimised.
        polytopes: the joint limits at few nodes, and at many.
        middle: a motion inside them.
        effort: when to end.
        seed: of the random starts.
        report: is called after each start.

    Raises:
        InputError: the limits of the base leave no room even for the gentlest motion.
    """
    searched = Searched()
    try:
        while effort.fraction(searched.starts) < 1 or not searched.random:
            random = np.random.default_rng([seed, searched.starts])
            descent = _Descent(problem, polytopes[0], effort)
            y = _start(descent, searched, middle, random)
            searched.starts += 1
            _descend(descent, y, searched)
            report(
                Progress(
                    effort.fraction(searched.starts),
                    float(np.exp(searched.best.value)),
                    searched.starts,
                )
            )
        _polish(problem, polytopes[1], effort, searched)
    except KeyboardInterrupt:
        # Without a first motion there is nothing to keep.
        if not searched.random:
            raise
        searched.interrupted = True
    return searched


def _polish(
    problem: Problem, polytope: Polytope, effort: Effort, searched: Searched
) -> None:
    """Replaces the best optima by those under the limits at many nodes."""
    best, searched.optima = searched.optima[:POLISHED], []
    try:
        for optimum in () if effort.over(1.0) else best:
            descent = _Descent(problem, polytope, effort, NEAR, until=1.0)
            _descend(descent, optimum.y, searched, (LAST_POWER,))
    finally:
        searched.optima = searched.optima or best


def _descend(
    descent: "_Descent",
    y: Float[np.ndarray, "joints m"],
    searched: Searched,
    powers: tuple[float, ...] = POWERS,
) -> None:
    """One descent; what it found is kept, however it ends."""
    try:
        descent.run(y, powers)
    finally:
        searched.evaluations += descent.evaluations
        if np.isfinite(descent.best.value):
            searched.keep(descent.best)


class _Descent:
    """One start, and the best motion met on its way that is inside all limits."""

    def __init__(
        self,
        problem: Problem,
        polytope: Polytope,
        effort: Effort,
        near: float = np.inf,
        until: float = SEARCHING,
    ) -> None:
        """Limits that are nearer than `near` at the start are kept to.

        It ends when the share `until` of a budget is used up.
        """
        self.problem, self.polytope, self._effort = problem, polytope, effort
        self._near, self._until = near, until
        self._last: tuple[bytes, Tried] | None = None
        self.best = Found(np.inf, np.empty((0, 0)))
        self.evaluations = 0

    def tried(self, y: Float[np.ndarray, "joints m"], p: float) -> Tried:
        """The criterion at `y`; SLSQP asks for values, then for limits."""
        key = np.append(y, p).tobytes()
        if self._last is None or self._last[0] != key:
            tried = self.problem.tried(y, p)
            self.evaluations += 1
            self._last = key, tried
            inside = self.polytope.slack(y).min() > -OUTSIDE
            if inside and (tried.used <= 1).all() and tried.exact < self.best.value:
                self.best = Found(tried.exact, y.copy())
        return self._last[1]

    def run(self, y: Float[np.ndarray, "joints m"], powers: tuple[float, ...]) -> None:
        """Descends with means of rising power."""
        try:
            for p in powers:
                y = self._slsqp(y, p)
        except _TimeIsUpError:
            return

    def _slsqp(
        self, y: Float[np.ndarray, "joints m"], p: float
    ) -> Float[np.ndarray, "joints m"]:
        shape = y.shape
        rows = self.polytope.rows
        kept = rows.any(axis=1) & (self.polytope.slack(y).ravel() < self._near)
        normals, room = rows[kept], self.polytope.room.ravel()[kept]
        base = len(self.problem.limited)

        def value(x: np.ndarray) -> tuple[float, np.ndarray]:
            tried = self.tried(x.reshape(shape), p)
            if self._effort.over(self._until):
                raise _TimeIsUpError
            return tried.smooth, tried.gradient.ravel()

        def slack(x: np.ndarray) -> np.ndarray:
            joints = room - normals @ x
            if not base:
                return joints
            return np.concatenate([1 - self.tried(x.reshape(shape), p).used, joints])

        def slack_gradient(x: np.ndarray) -> np.ndarray:
            if not base:
                return -normals
            used = self.tried(x.reshape(shape), p).used_gradient
            return -np.concatenate([used.reshape(base, -1), normals])

        found = minimize(
            value,
            y.ravel(),
            jac=True,
            method="SLSQP",
            constraints={"type": "ineq", "fun": slack, "jac": slack_gradient},
            options={"maxiter": MOST_STEPS, "ftol": TOLERANCE},
        )
        return found.x.reshape(shape)


def _start(
    descent: _Descent,
    searched: Searched,
    middle: Float[np.ndarray, "joints m"],
    random: np.random.Generator,
) -> Float[np.ndarray, "joints m"]:
    """A random motion, or one beside a good one; inside all limits."""
    good = searched.optima[:BEST]
    direction = random.standard_normal(middle.shape)
    if searched.starts < FIRST_RANDOM or searched.starts % 2 == 0 or not good:
        share = random.uniform(*SHARES, len(middle))
        steps = share * descent.polytope.reach(middle, direction)
        y = middle + steps[:, None] * direction
        found = _inside_base_limits(descent, middle, y)
        searched.random.append(found)
        return found.y
    y = middle + INWARD * (good[random.integers(len(good))].y - middle)
    steps = np.minimum(ASIDE, SHARES[1] * descent.polytope.reach(y, direction))
    return _inside_base_limits(descent, middle, y + steps[:, None] * direction).y


def _inside_base_limits(
    descent: _Descent,
    middle: Float[np.ndarray, "joints m"],
    y: Float[np.ndarray, "joints m"],
) -> Found:
    """The motion, halved towards the gentlest one until the base keeps its limits."""
    tried = descent.tried(y, POWERS[0])
    for _ in range(MOST_HALVINGS):
        if (tried.used < 1).all():
            return Found(tried.exact, y)
        y = middle + (y - middle) / 2
        tried = descent.tried(y, POWERS[0])
    worst = int(tried.used.argmax())
    raise InputError(
        "base limits: even the gentlest joint motion exceeds the limit of "
        f"{descent.problem.limited[worst]}, by {np.sqrt(tried.used[worst]) - 1:.2g} "
        "of it; raise the limit, or start with less momentum"
    )
