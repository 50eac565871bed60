"""Where Earth, air, sun and field are, as the base of a flying robot sees them."""

import numpy as np
from jaxtyping import Float

from orbident.model.rotations import rotate_back
from orbident.simulation.environment.moving import Vectors
from orbident.simulation.environment.orbit import place
from orbident.trajectories.environment import Environment


def seen_from_base(
    environment: Environment,
    t: Float[np.ndarray, " rows"],
    R_WB: Float[np.ndarray, "rows 3 3"],
) -> dict[str, Float[np.ndarray, " rows"]]:
    """The columns `nadir`, `flow`, `field` and `sun`, without noise.

    Args:
        environment: with an orbit, or with the sun.
        t: the times of the rows, s.
        R_WB: the attitude.
    """
    shown: dict[str, Vectors] = {}
    if environment.orbit is not None:
        at = place(environment.orbit, t - t[0])
        wind = np.linalg.norm(at.wind, axis=1, keepdims=True)
        shown |= {"nadir": -at.R * at.up, "flow": -at.wind / wind, "field": at.field}
    if environment.solar_pressure is not None:
        sun = np.array(environment.solar_pressure.sun)
        shown["sun"] = np.tile(sun / np.linalg.norm(sun), (t.size, 1))
    return {
        f"{name}.{axis}": column
        for name, vectors in shown.items()
        for axis, column in zip("xyz", rotate_back(R_WB, vectors).T, strict=True)
    }
