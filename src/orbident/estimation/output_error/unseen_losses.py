"""A torque that nobody said acts may be momentum that wheels lost unseen.

A wheel that slows down while its recorded speed stays gives its momentum to the rest of
the robot, as a torque from outside would. About the vertical of a table the two are the
same, and a steady torque gives the right result. In space, and by a torque that changes
slowly, the loss is followed nearly: the wheels' momentum at the start then counts for
the whole recording, and all of `beta`, which is in proportion to it, is wrong by up to
the part that was lost. Nothing in a recording says which of the two it was, so
deviations hold both, unless the user says that a torque acts.
"""

from collections.abc import Collection

import numpy as np
from jaxtyping import Float

from orbident.estimation.output_error.disturbance_sizes import members, sizes_of
from orbident.estimation.output_error.followed import integral
from orbident.estimation.output_error.forms import SLOW
from orbident.estimation.output_error.problem import Problem
from orbident.estimation.output_error.solver import Solution
from orbident.model.wheel_arrays import wheels_of


def may_be_losses(motion: str, freed: Collection[str], asked: Collection[str]) -> bool:
    """Whether torques among the freed groups may be what wheels lost.

    Args:
        motion: the robot's, `"planar"` or `"spatial"`.
        freed: groups of what acts from outside, which are unknowns.
        asked: the groups of these that the user says act.
    """
    torques = {group for group in freed if "torque" in group}
    same = motion == "planar" and not torques & {*SLOW}
    return bool(torques) and not same and not torques & {*asked}


def unseen_losses(
    problem: Problem,
    solution: Solution,
    freed: Collection[str],
    asked: Collection[str],
) -> Float[np.ndarray, " beta"]:
    """Deviation of `beta` by what wheels may have lost; zero without such a torque.

    Args:
        problem: a recording's equations.
        solution: of these.
        freed: the groups that it has among its unknowns.
        asked: the groups of these that the user says act.
    """
    followed, beta = problem.acting.followed, solution.state.beta
    if not may_be_losses(followed.robot.motion, freed, asked):
        return np.zeros(beta.size)
    by_torque = np.zeros((followed.t.size, 3))
    for group in (each for each in freed if "torque" in each):
        sizes, _ = sizes_of(problem, solution, group)
        for size, each in zip(sizes, members(problem, group), strict=True):
            by_torque += size * integral(followed.t, each.effect.torque)
    of_wheels = followed.qd_rw @ wheels_of(followed.robot).A_rw.T
    had = _largest(of_wheels)
    return _largest(by_torque) / had * beta if had else np.zeros(beta.size)


def _largest(h: Float[np.ndarray, "nodes 3"]) -> float:
    return float(np.linalg.norm(h, axis=1).max())
