"""The part of the nominal bodies of which no motion shows anything.

It has no momentum in the geometry that is declared. With joints elsewhere it has, by
the product of its own size and the change of geometry.
"""

import numpy as np
from jaxtyping import Float

from orbident.model.minimal_sets import MinimalSets
from orbident.robot.description import Robot
from orbident.robot.parameters import (
    FIRST_MOMENT,
    INERTIA_ENTRIES,
    MASS,
    inertia_matrix,
)


def unseen_part(robot: Robot, sets: MinimalSets) -> Float[np.ndarray, " theta"]:
    """What remains of the nominal `theta` beside what its base parameters give.

    Args:
        robot: with its nominal bodies.
        sets: its minimal sets.
    """
    bodies = _flat(robot) if robot.motion == "planar" else robot.theta
    return bodies.ravel() - sets.base.theta_of @ sets.beta(robot.theta)


def _flat(robot: Robot) -> Float[np.ndarray, "bodies 10"]:
    """The bodies of a planar robot, all in the plane of S.

    Nothing there shows how high a CM is, but a height couples tilts to positions.
    """
    # Of each body: the plane's normal in its axes, and its origin's height, m.
    places = [(np.array([0.0, 0.0, 1.0]), 0.0)]
    for joint in robot.joints:
        n, height = places[joint.parent]
        places.append((joint.R_PJ.T @ n, height + float(n @ joint.p_PJ)))
    flat = []
    for theta, (n, height) in zip(robot.theta, places, strict=True):
        m, s = theta[MASS], theta[FIRST_MOMENT]
        about_n = (n @ inertia_matrix(theta) @ n) * np.outer(n, n)
        in_plane = s - n * (n @ s + m * height)
        flat.append([m, *in_plane, *(about_n[entry] for entry in INERTIA_ENTRIES)])
    return np.array(flat)
