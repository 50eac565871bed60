"""Descent inside limits: a barrier for the limits, quasi-Newton for the criterion.

Joint limits are linear, so their barrier `-mu sum log slack` has an exact Hessian; only
the criterion's is approximated (damped BFGS). Every iterate is inside the limits. From
stage to stage `mu` falls and the power `p` of the means that stand for extreme
eigenvalues rises.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.excitation.polytope import Polytope

STAGES = ((1e-2, 2.0), (1e-3, 8.0), (1e-4, 32.0), (1e-5, 128.0))
"""`mu` and `p`: at the last, both are below a percent of the condition number."""

MOST_STEPS = 25
"""A stage; a stage more does more than steps more."""

MOST_CUTS = 12
TO_THE_WALL = 0.95
ARMIJO = 1e-4
SMALL = 1e-3
"""Of the barrier's weight: a step that gains less ends a stage."""

Function = Callable[
    [Float[np.ndarray, "joints m"], float, float],
    tuple[float, float, Float[np.ndarray, "joints m"]],
]
"""Smooth and exact value, and gradient of the smooth one, at `y, p, mu`."""


class Found(NamedTuple):
    """The best motion met on the way."""

    y: Float[np.ndarray, "joints m"]
    value: float
    """Exact logarithm of the criterion."""
    evaluations: int


class _At(NamedTuple):
    y: Float[np.ndarray, "joints m"]
    smooth: float
    exact: float
    gradient: Float[np.ndarray, "joints m"]


def descend(
    function: Function,
    polytope: Polytope,
    y: Float[np.ndarray, "joints m"],
    stopping: Callable[[], bool],
) -> Found:
    """From a point inside the limits to a local optimum inside them.

    Args:
        function: the criterion.
        polytope: the joint limits.
        y: where to start.
        stopping: is asked after each step whether time is up.
    """
    H = np.eye(y.size)
    evaluations, best = 0, Found(y, np.inf, 0)
    for mu, p in STAGES:
        at, evaluations = _evaluated(function, y, p, mu), evaluations + 1
        for _ in range(MOST_STEPS):
            if at.exact < best.value:
                best = Found(at.y, at.exact, 0)
            step, slope = _newton_step(polytope, at, H, mu)
            if -slope < SMALL * mu or stopping():
                break
            there, tries = _line_search(function, polytope, at, step, slope, p, mu)
            evaluations += tries
            if there is None:
                break
            H = _damped_bfgs(
                H, (there.y - at.y).ravel(), (there.gradient - at.gradient).ravel()
            )
            at = there
        y = at.y
        if at.exact < best.value:
            best = Found(at.y, at.exact, 0)
    return best._replace(evaluations=evaluations)


def _evaluated(
    function: Function, y: Float[np.ndarray, "joints m"], p: float, mu: float
) -> _At:
    return _At(y, *function(y, p, mu))


def _newton_step(
    polytope: Polytope, at: _At, H: Float[np.ndarray, "n n"], mu: float
) -> tuple[Float[np.ndarray, "joints m"], float]:
    """The step, and the slope of criterion and barrier along it."""
    joints, m = at.y.shape
    per_slack = polytope.normals / polytope.slack(at.y)[:, :, None]
    gradient = (at.gradient + mu * per_slack.sum(axis=1)).ravel()
    H = H.copy()
    for k in range(joints):
        own = slice(k * m, (k + 1) * m)
        H[own, own] += mu * per_slack[k].T @ per_slack[k]
    step = -np.linalg.solve(H, gradient)
    return step.reshape(joints, m), float(gradient @ step)


def _line_search(
    function: Function,
    polytope: Polytope,
    at: _At,
    step: Float[np.ndarray, "joints m"],
    slope: float,
    p: float,
    mu: float,
) -> tuple[_At | None, int]:
    """Backtracking to a sufficient decrease (Armijo); None where there is none."""
    barrier = -mu * np.log(polytope.slack(at.y)).sum()
    length = min(1.0, TO_THE_WALL * float(polytope.reach(at.y, step).min()))
    for tries in range(1, MOST_CUTS + 1):
        there = _evaluated(function, at.y + length * step, p, mu)
        change = there.smooth - mu * np.log(polytope.slack(there.y)).sum()
        change -= at.smooth + barrier
        if change <= ARMIJO * length * slope and np.isfinite(there.gradient).all():
            return there, tries
        length *= 0.4
    return None, MOST_CUTS


def _damped_bfgs(
    H: Float[np.ndarray, "n n"],
    s: Float[np.ndarray, " n"],
    change: Float[np.ndarray, " n"],
) -> Float[np.ndarray, "n n"]:
    """Powell's: stays positive where the criterion is not convex."""
    Hs = H @ s
    sHs, sy = s @ Hs, s @ change
    share = 1.0 if sy >= 0.2 * sHs else 0.8 * sHs / (sHs - sy)
    r = share * change + (1 - share) * Hs
    return H - np.outer(Hs, Hs) / sHs + np.outer(r, r) / (s @ r)
