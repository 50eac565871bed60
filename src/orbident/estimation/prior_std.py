"""What is known of `beta` before anything is measured: hardly anything."""

import numpy as np
from jaxtyping import Float

from orbident.model.inertia import inertia_at
from orbident.model.minimal_sets import MinimalSets
from orbident.robot.description import Robot
from orbident.robot.parameters import MASS

WIDE = 100.0
"""Times the robot's own scale: no robot is so far from its CAD values."""


def prior_std(robot: Robot, sets: MinimalSets) -> Float[np.ndarray, " beta"]:
    """Standard deviations about the nominal values of `[M, sigma, iota]`.

    `M`, `M L` and `M L^2` with `L` the nominal radius of gyration, a hundred times
    each: what the recording tells, it tells far better, and what it does not tell
    keeps the equations solvable and is recognised by it.
    """
    D = inertia_at(robot, np.zeros(len(robot.joints))).D
    M = float(robot.theta[:, MASS].sum())
    # Of CAD values that no body can have, D may be anything.
    L = float(np.sqrt(np.abs(np.diag(D)).sum() / M))
    size = np.repeat([1.0, L, L**2], [1, sets.base.sigmas, sets.iotas])
    return WIDE * M * size


EXACT = 1e-6
"""Differences below this part of the robot's own scale are interpolation's."""


def exact_std(robot: Robot, sets: MinimalSets) -> Float[np.ndarray, " beta"]:
    """What base parameters of recordings without noise may differ by."""
    return EXACT / WIDE * prior_std(robot, sets)
