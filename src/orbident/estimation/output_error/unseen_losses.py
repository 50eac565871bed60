"""A torque that nobody said acts may be momentum that wheels lost unseen.

A wheel that slows down while its recorded speed stays gives its momentum to the rest of the
robot, as a torque from outside would. Torques that change slowly follow it closely, and
with them the wheels' momentum at the start counts for the whole recording: everything
that is in proportion to it, which is all of `beta`, is then wrong by up to the part that
was lost. Nothing in a recording says which of the two it was, so deviations hold both.
"""

from collections.abc import Collection

import numpy as np
from jaxtyping import Float

from orbident.estimation.found import BetaEstimate
from orbident.estimation.output_error.disturbance_sizes import members, sizes_of
from orbident.estimation.output_error.followed import integral
from orbident.estimation.output_error.forms import SLOW
from orbident.estimation.output_error.problem import Problem
from orbident.estimation.output_error.solver import Solution
from orbident.model.wheel_arrays import wheels_of


def with_unseen_losses(
    estimate: BetaEstimate, problem: Problem, solution: Solution, freed: Collection[str]
) -> BetaEstimate:
    """The estimate with deviations that hold what wheels may have lost.

    Args:
        estimate: as if all torques acted from outside.
        problem: a recording's equations.
        solution: of these.
        freed: the groups that were freed though nobody said that they act.
    """
    torques = [group for group in freed if "torque" in group]
    if not any(group in SLOW for group in torques):
        return estimate
    scale = lost_part(problem, solution, torques) * estimate.values
    return estimate._replace(covariance=estimate.covariance + np.outer(scale, scale))


def lost_part(problem: Problem, solution: Solution, torques: Collection[str]) -> float:
    """The largest momentum by these torques, over the largest of the wheels."""
    followed = problem.acting.followed
    by_torque = np.zeros((followed.t.size, 3))
    for group in torques:
        sizes, _ = sizes_of(problem, solution, group)
        for size, each in zip(sizes, members(problem, group), strict=True):
            by_torque += size * integral(followed.t, each.effect.torque)
    of_wheels = followed.history.qd_rw @ wheels_of(followed.robot).A_rw.T
    had, got = _largest(of_wheels), _largest(by_torque)
    return got / had if had else 0.0


def _largest(h: Float[np.ndarray, "nodes 3"]) -> float:
    return float(np.linalg.norm(h, axis=1).max())
