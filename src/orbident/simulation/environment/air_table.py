"""A table that is neither level nor even, and the drag of the air film on it.

    pull   F_i = m_i a(r_i),   a(r) = g theta + A r   each body, at its CM; A symmetric
    film   F = -c v_P,   tau = -c_r w_i               bodies with pads

`theta` is how far the table falls along inertial x and y, and `r` is from the origin.
"""

import numpy as np
from jaxtyping import Float

from orbident.robot.units import STANDARD_GRAVITY
from orbident.simulation.environment.moving import (
    Load,
    Moving,
    Vectors,
    heavy_bodies,
)
from orbident.trajectories.environment import Environment, Film

IN_PLANE = np.array([1.0, 1.0, 0.0])
ABOUT_Z = np.array([0.0, 0.0, 1.0])


def pull(environment: Environment, r: Float[np.ndarray, "n 3"]) -> Vectors:
    """The acceleration `a(r)` of what is at `r` (m); inertial axes, m/s^2."""
    fall, uneven = environment.tilt or (0.0, 0.0), environment.uneven
    a = np.tile(STANDARD_GRAVITY * np.array([*fall, 0.0]), (len(r), 1))
    if uneven is not None:
        A = np.array([[uneven.xx, uneven.xy], [uneven.xy, uneven.yy]])
        a[:, :2] += r[:, :2] @ A
    return a


def pulls(environment: Environment, moving: Moving) -> list[Load]:
    """The pull of the table on each body, at its CM."""
    return [
        moving.acting(i, com, force=m * pull(environment, moving.point(i, com).r))
        for i, m, com in heavy_bodies(moving.robot)
    ]


def film_drag(body: str, film: Film, moving: Moving) -> list[Load]:
    """The drag of the air film under the pads of a body."""
    i, pad = moving.robot.bodies.index(body), moving.robot.pads[body]
    force = -film.c * moving.point(i, pad).v * IN_PLANE
    return [moving.acting(i, pad, force, -film.c_r * moving.rate(i) * ABOUT_Z)]
