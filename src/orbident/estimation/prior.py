"""What is known of `beta` before anything is measured: hardly anything."""

import numpy as np
from jaxtyping import Float

from orbident.compilation import compiled
from orbident.dynamics.inertia import inertia
from orbident.dynamics.tree import tree_of
from orbident.regressors.minimal_sets import MinimalSets
from orbident.robot.description import Robot

WIDE = 100.0
"""Times the robot's own scale: no robot is so far from its CAD values."""

_inertia = compiled(inertia)


def prior_std(robot: Robot, sets: MinimalSets) -> Float[np.ndarray, " beta"]:
    """Standard deviations about the nominal values of `[M, sigma, iota]`.

    `M`, `M L` and `M L^2` with `L` the nominal radius of gyration, a hundred times
    each: what the recording tells, it tells far better, and what it does not tell
    keeps the equations solvable and is recognised by it.
    """
    at = _inertia(tree_of(robot), robot.theta, np.zeros(len(robot.joints)))
    # Of CAD values that no body can have, D may be anything.
    L = float(np.sqrt(np.abs(np.diag(at.D)).sum() / at.M))
    size = np.repeat([1.0, L, L**2], [1, sets.base.sigmas, sets.iotas])
    return WIDE * float(at.M) * size
