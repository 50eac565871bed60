"""One descent: sequential quadratic programming (SLSQP of SciPy), exact gradients."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.optimize import minimize

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

    power: float
    """Power of the means for extreme eigenvalues: smooth if low, exact if high."""
    near: float
    """Share of a limit: limits farther off at the start are not given to SLSQP."""
    until: float
    """Share of a budget after which the stage ends."""


class Feasible(NamedTuple):
    """A motion inside the limits."""

    value: float
    """Logarithm of the criterion, on the search's grid."""
    y: Float[np.ndarray, "joints m"]


class _EndedError(Exception):
    """Ends a descent."""


class Descent:
    """One descent, and the best motion met on its way that is inside all limits."""

    def __init__(
        self,
        problem: DesignProblem,
        polytope: Polytope,
        stage: DescentStage,
        time_is_up: Callable[[], bool],
    ) -> None:
        """It ends early when the time is up, or a step leads far from all limits."""
        self._problem, self._polytope, self._stage = problem, polytope, stage
        self._time_is_up = time_is_up
        self._last: tuple[bytes, Candidate] | None = None
        self.best: Feasible | None = None
        self.evaluations = 0

    def run(self, y: Float[np.ndarray, "joints m"]) -> None:
        """Descends from a motion."""
        shape = y.shape
        slack = self._polytope.slack(y).ravel()
        kept = self._polytope.rows.any(axis=1) & (slack < self._stage.near)
        normals = self._polytope.rows[kept]
        room = self._polytope.room.ravel()[kept]
        base = len(self._problem.limited)

        def value(x: np.ndarray) -> tuple[float, np.ndarray]:
            candidate = self._candidate(x.reshape(shape))
            if self._time_is_up():
                raise _EndedError
            return candidate.smooth, candidate.gradient.ravel()

        def slacks(x: np.ndarray) -> np.ndarray:
            joints = room - normals @ x
            if not base:
                return joints
            return np.concatenate([1 - self._candidate(x.reshape(shape)).used, joints])

        def slack_gradients(x: np.ndarray) -> np.ndarray:
            if not base:
                return -normals
            used = self._candidate(x.reshape(shape)).used_gradient
            return -np.concatenate([used.reshape(base, -1), normals])

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

    def _candidate(self, y: Float[np.ndarray, "joints m"]) -> Candidate:
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
                self.best = Feasible(candidate.exact, y.copy())
        return self._last[1]
