"""Robots that could be the true one, as far as the nominal inertia is uncertain."""

import numpy as np
from jaxtyping import Float

from orbident.robot.parameters import FIRST_MOMENT, INERTIA, MASS

ROBOTS = 6
"""Beside the nominal one: the worst of more is hardly worse."""


def plausible_thetas(
    theta: Float[np.ndarray, "bodies 10"], uncertainty: float
) -> Float[np.ndarray, "robots bodies 10"]:
    """Each body heavier or lighter and longer or shorter, by a factor of its own.

    A body of mass m (1 + e) and size l (1 + f) can exist if the nominal one can, and
    keeps its CM's axis and its principal axes.

    Args:
        theta: the nominal inertia; the first of those returned.
        uncertainty: standard deviation of e and f.
    """
    if uncertainty == 0.0:
        return theta[None]
    random = np.random.default_rng(0)
    e, f = uncertainty * random.standard_normal((2, ROBOTS, len(theta)))
    heavier, longer = np.exp(e), np.exp(f)
    thetas = np.repeat(theta[None], ROBOTS, axis=0)
    thetas[:, :, MASS] *= heavier
    thetas[:, :, FIRST_MOMENT] *= (heavier * longer)[..., None]
    thetas[:, :, INERTIA] *= (heavier * longer**2)[..., None]
    return np.concatenate([theta[None], thetas])
