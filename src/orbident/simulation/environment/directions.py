"""Where Earth, air, sun and field are, as the base of a flying robot sees them."""

import numpy as np
from jaxtyping import Float

from orbident.model.rotations import rotate_back
from orbident.orbits.orbit import Arc
from orbident.simulation.environment.moving import Vectors
from orbident.simulation.environment.orbital import sun_of
from orbident.trajectories.environment import Environment


def seen_from_base(
    environment: Environment,
    arc: Arc | None,
    t: Float[np.ndarray, " rows"],
    R_WB: Float[np.ndarray, "rows 3 3"],
) -> dict[str, Float[np.ndarray, " rows"]]:
    """The columns `nadir`, `flow`, `field` and `sun`, without noise.

    Args:
        environment: perhaps with the sun's direction.
        arc: of the orbit, if there is one.
        t: the times of the rows, s.
        R_WB: the attitude.
    """
    shown: dict[str, Vectors] = {}
    if arc is not None:
        speed = np.linalg.norm(arc.wind(t), axis=1, keepdims=True)
        shown |= {"nadir": -arc.place(t), "flow": -arc.wind(t) / speed}
        shown["field"] = arc.field(t)
    if environment.solar_pressure is not None:
        shown["sun"] = sun_of(environment.solar_pressure, arc, t)
    return {
        f"{name}.{axis}": column
        for name, vectors in shown.items()
        for axis, column in zip("xyz", rotate_back(R_WB, vectors).T, strict=True)
    }
