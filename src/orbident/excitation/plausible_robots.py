"""Robots that may be the true one, where its inertia is known to a fraction only."""

from dataclasses import replace

import numpy as np

from orbident.robot.description import Robot
from orbident.robot.parameters import FIRST_MOMENT, INERTIA, MASS

ROBOTS = 6
"""Plausible robots beside the nominal one: the worst of more is hardly worse."""


def plausible_robots(robot: Robot, uncertainty: float) -> list[Robot]:
    """Each body heavier or lighter and longer or shorter, by a factor of its own.

    A body of mass m (1 + e) and size l (1 + f) can exist if the nominal one can, and
    keeps its CM's axis and its principal axes.

    Args:
        robot: with the nominal inertia; the first of those returned.
        uncertainty: standard deviation of e and f.
    """
    if uncertainty == 0.0:
        return [robot]
    random = np.random.default_rng(0)
    e, f = uncertainty * random.standard_normal((2, ROBOTS, len(robot.theta)))
    heavier, longer = np.exp(e), np.exp(f)
    thetas = np.repeat(robot.theta[None], ROBOTS, axis=0)
    thetas[:, :, MASS] *= heavier
    thetas[:, :, FIRST_MOMENT] *= (heavier * longer)[..., None]
    thetas[:, :, INERTIA] *= (heavier * longer**2)[..., None]
    return [robot, *(replace(robot, theta=theta) for theta in thetas)]
