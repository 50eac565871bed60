"""What every method should find."""

import numpy as np

from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import Robot


def truth(robot: Robot) -> dict[str, np.ndarray]:
    sets, theta = minimal_sets(robot), robot.theta
    return {
        "pi": sets.pi(theta),
        "phi": sets.phi(theta),
        "base": sets.beta(theta),
        "mass": np.array([robot.mass]),
    }
