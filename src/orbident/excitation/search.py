"""One search: motions are drawn inside their limits, and the best one is kept.

Motions of joints have many starts, from random ones to the best local optima. All are
descended on a smooth criterion, by sequential quadratic programming with exact
gradients. Half of them are good motions that are known already, with one joint's motion
made anew: what is good in one joint is often good beside another motion of the next.
Only the best are then descended on a sharp criterion, and of these the best under more
limits.
"""

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import ceil
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.optimize import minimize

from orbident.errors import InputError
from orbident.excitation.design_problem import Candidate, DesignProblem
from orbident.excitation.joint_limits import Polytope

MOST_STEPS = 100

TOLERANCE = 1e-4
"""Least gain of the criterion's logarithm: a step that gains less ends a descent."""

OUTSIDE = 1e-6
"""Share of a limit by which a motion may exceed it: rounding in SLSQP's steps, and far
less than limits are kept back."""

LOST = 1e6
"""Times a limit: beyond it nothing is sought, and the fourth powers of such numbers are
still far from an overflow."""


class DescentStage(NamedTuple):
    """Descents of one kind."""

    polytope: int
    """Which of a space's: the joints' limits at few nodes, at more or at many."""
    power: float
    """Power of the means for extreme eigenvalues: smooth if low, exact if high."""
    near: float
    """Share of a limit: limits farther off at the start are not given to SLSQP."""
    until: float
    """Share of a budget after which the stage ends."""


class SearchSpace(NamedTuple):
    """Motions of so many harmonics."""

    problem: DesignProblem
    polytopes: tuple[Polytope, Polytope, Polytope]
    """The joint limits at few nodes, at more and at many."""
    middle: Float[np.ndarray, "free m"]
    """A motion inside them."""


class Feasible(NamedTuple):
    """A motion inside the limits."""

    space: SearchSpace
    value: float
    """Logarithm of the criterion, on the search's grid."""
    y: Float[np.ndarray, "free m"]


class _EndedError(Exception):
    """Ends a descent."""


class Descent:
    """One descent, and the best motion met on its way that is inside all limits."""

    def __init__(
        self, space: SearchSpace, stage: DescentStage, time_is_up: Callable[[], bool]
    ) -> None:
        """It ends early when the time is up, or a step leads far from all limits."""
        self._space, self._stage = space, stage
        self._problem, self._polytope = space.problem, space.polytopes[stage.polytope]
        self._time_is_up = time_is_up
        self._last: tuple[bytes, Candidate] | None = None
        self.best: Feasible | None = None
        self.evaluations = 0

    def run(self, y: Float[np.ndarray, "free m"]) -> None:
        """Descends from a motion."""
        shape = y.shape
        slack = self._polytope.slack(y).ravel()
        kept = self._polytope.rows.any(axis=1) & (slack < self._stage.near)
        normals = self._polytope.rows[kept]
        room = self._polytope.room.ravel()[kept]

        def value(x: np.ndarray) -> tuple[float, np.ndarray]:
            candidate = self._candidate(x.reshape(shape))
            if self._time_is_up():
                raise _EndedError
            return candidate.smooth, candidate.gradient.ravel()

        def slacks(x: np.ndarray) -> np.ndarray:
            used = self._candidate(x.reshape(shape)).used
            return np.concatenate([1 - used, room - normals @ x])

        def slack_gradients(x: np.ndarray) -> np.ndarray:
            used = self._candidate(x.reshape(shape)).used_gradient
            return -np.concatenate([used.reshape(len(used), x.size), normals])

        try:
            minimize(
                value,
                y.ravel(),
                jac=True,
                method="SLSQP",
                constraints={"type": "ineq", "fun": slacks, "jac": slack_gradients},
                options={"maxiter": MOST_STEPS, "ftol": TOLERANCE},
            )
        except _EndedError:
            return

    def _candidate(self, y: Float[np.ndarray, "free m"]) -> Candidate:
        """The criterion at `y`; SLSQP asks for values, then for limits."""
        # A subproblem without a solution sends SLSQP anywhere.
        if not self._polytope.slack(y).min() > -LOST:
            raise _EndedError
        key = y.tobytes()
        if self._last is None or self._last[0] != key:
            candidate = self._problem.evaluate(y, self._stage.power)
            self.evaluations += 1
            self._last = key, candidate
            inside = self._polytope.slack(y).min() > -OUTSIDE
            better = self.best is None or candidate.exact < self.best.value
            if inside and (candidate.used <= 1).all() and better:
                self.best = Feasible(self._space, candidate.exact, y.copy())
        return self._last[1]


FIRST = DescentStage(0, power=8.0, near=np.inf, until=0.5)
SECOND = DescentStage(1, power=128.0, near=np.inf, until=0.9)
LAST = DescentStage(2, power=512.0, near=0.1, until=1.0)

FOLLOWED = 8
"""One start of so many is descended again; with a budget, as many as time allows."""

POLISHED = 3
"""So many of the best optima are descended once more."""

SHARES = 0.5, 0.95
"""A random motion takes a share between these of what the joints' limits allow."""

FIRST_RANDOM = 8
"""So many starts are random, then every second one."""

BEST = 6
"""A start with one joint made anew takes the others from one of so many."""

INWARD = 0.9
"""Share of their amplitude that those keep: limits are then free."""

MOST_HALVINGS = 20

VAIN = 20
"""So many motions beyond their limits for each that is not: limits are too tight."""

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
    """How long to search: so many starts and evaluations, or until a moment."""

    starts: int
    budget: float | None
    """Seconds; the numbers of starts and evaluations then do not matter."""
    evaluations: int = 0
    """Starts go on until they took so many: short descents leave time for more."""
    began: float = field(default_factory=time.perf_counter)

    def begins(self, searched: "Searched", until: float) -> bool:
        """Whether one more start is to begin, up to a share of the budget."""
        starts = searched.starts
        if searched.refused + starts >= VAIN * (1 + starts):
            return False
        if self.budget:
            return starts == 0 or self.used < until
        return starts < self.starts or searched.evaluations < self.evaluations

    @property
    def used(self) -> float:
        """Share of the budget; zero without any."""
        if not self.budget:
            return 0.0
        return (time.perf_counter() - self.began) / self.budget


@dataclass
class Searched:
    """What a search has found so far: motions with a `value`, the less the better."""

    random: list[Any] = field(default_factory=list)
    """Random motions, before any descent."""
    optima: list[Any] = field(default_factory=list)
    """The best first; nearly equal ones once."""
    starts: int = 0
    refused: int = 0
    """Motions beside these that were drawn and do not keep to their limits."""
    descents: int = 0
    evaluations: int = 0
    interrupted: bool = False

    def keep(self, found: Feasible) -> None:
        """Adds an optimum in its place."""
        near = [each for each in self.optima if abs(each.value - found.value) < ALIKE]
        if any(each.value <= found.value for each in near):
            return
        # Of two that are alike, the better.
        self.optima = sorted(
            [*(each for each in self.optima if each not in near), found],
            key=lambda each: each.value,
        )


@dataclass(eq=False)
class MotionSearch(ABC):
    """Motions of one kind, searched with an effort."""

    effort: Effort
    report: Callable[[Progress], object]
    """Is called after each start and descent."""
    searched: Searched = field(default_factory=Searched, init=False)

    @abstractmethod
    def search(self) -> None:
        """Draw motions while the effort allows; keep those within their limits."""

    def later(self, starts: float) -> float:
        """How much more there is to do after so many starts, in starts."""
        return 0.0

    def run(self) -> Searched:
        """Search; an interrupt ends it, and what it found is kept.

        Raises:
            InputError: the limits of the base leave no room for any motion of joints.
        """
        searched = self.searched
        try:
            self.search()
        except KeyboardInterrupt:
            # Without a first motion there is nothing to keep.
            if not searched.random:
                raise
            searched.interrupted = True
        return searched

    def tell(self, done: int) -> None:
        """Report, after so many starts and descents."""
        found, effort = self.searched, self.effort
        least = found.starts * effort.evaluations / max(found.evaluations, 1)
        starts = float(max(effort.starts, found.starts, least))
        fraction = (
            effort.used if effort.budget else done / (starts + self.later(starts))
        )
        values = (each.value for each in (*found.optima, *found.random))
        best = float(np.exp(min(values, default=np.inf)))
        self.report(Progress(min(fraction, 1.0), best, found.starts + found.refused))


@dataclass(eq=False)
class JointSearch(MotionSearch):
    """Descents from many motions of the joints."""

    spaces: Sequence[SearchSpace]
    """Random motions are drawn from each in turn."""
    seed: int
    """Seed of the generator that draws the random motions."""

    def search(self) -> None:
        """Descend from each start, from some optima again, and from the best of them.

        A start is a random motion, or a good one with a random joint.
        """
        while self.effort.begins(self.searched, FIRST.until):
            random = np.random.default_rng([self.seed, self.searched.starts])
            self._descend(self._drawn(random), FIRST)
        followed = ceil(self.searched.starts / FOLLOWED)
        self._again(None if self.effort.budget else followed, SECOND)
        self._again(POLISHED, LAST)

    def later(self, starts: float) -> float:
        """How many descents follow after so many starts."""
        return starts / FOLLOWED + POLISHED

    def _again(self, most: int | None, stage: DescentStage) -> None:
        """Replaces the optima by what descents from the best of them find."""
        before, self.searched.optima = self.searched.optima, []
        try:
            for each in before[:most]:
                if self.effort.used >= stage.until:
                    break
                self._descend(each, stage)
        finally:
            self.searched.optima = self.searched.optima or before

    def _descend(self, start: Feasible, stage: DescentStage) -> None:
        """One descent; what it found is kept, however it ends."""
        searched, effort = self.searched, self.effort
        descent = Descent(start.space, stage, lambda: effort.used >= stage.until)
        try:
            descent.run(start.y)
        finally:
            searched.evaluations += descent.evaluations
            searched.descents += 1
            if descent.best is not None:
                searched.keep(descent.best)
        self.tell(searched.descents)

    def _drawn(self, random: np.random.Generator) -> Feasible:
        """A random motion, or a good one with a random joint; inside all limits."""
        searched = self.searched
        good, is_random = searched.optima[:BEST], searched.starts % 2 == 0
        space = self.spaces[len(searched.random) % len(self.spaces)]
        searched.starts += 1
        y = _random_motion(space, random)
        if searched.starts <= FIRST_RANDOM or is_random or not good:
            found = _inside_base_limits(space, y)
            searched.random.append(found)
            return found
        # Limits hold joint by joint, so joints of two motions go together.
        best = good[random.integers(len(good))]
        mixed = best.space.middle + INWARD * (best.y - best.space.middle)
        joint = random.integers(len(mixed))
        if best.space is not space:
            y = _random_motion(best.space, random)
        mixed[joint] = y[joint]
        return _inside_base_limits(best.space, mixed)


def _random_motion(
    space: SearchSpace, random: np.random.Generator
) -> Float[np.ndarray, "free m"]:
    middle = space.middle
    direction = random.standard_normal(middle.shape)
    share = random.uniform(*SHARES, len(middle))
    steps = share * space.polytopes[FIRST.polytope].reach(middle, direction)
    return middle + steps[:, None] * direction


def _inside_base_limits(space: SearchSpace, y: Float[np.ndarray, "free m"]) -> Feasible:
    """The motion, halved towards the gentlest one until the base keeps its limits."""
    problem, middle = space.problem, space.middle
    candidate = problem.evaluate(y, FIRST.power)
    for _ in range(MOST_HALVINGS):
        if (candidate.used < 1).all():
            return Feasible(space, candidate.exact, y)
        y = middle + (y - middle) / 2
        candidate = problem.evaluate(y, FIRST.power)
    worst = int(candidate.used.argmax())
    raise InputError(
        "base limits: even the gentlest joint motion exceeds the limit of "
        f"{problem.limited[worst]}, by {np.sqrt(candidate.used[worst]) - 1:.2g} "
        "of it; raise it by --limit, or give less momentum (--wheel-speed, "
        "--initial-momentum at-rest) or other ends (--like)"
    )
