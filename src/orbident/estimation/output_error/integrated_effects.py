"""What forces and torques add up to: momentum, place and velocity of the system CM."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from orbident.environment.motion import Effect, at_nodes, by_step, integral

ROWS = 15
"""A node has so many: h_cm, its rate, r_cm, v_cm and what is felt, three axes each."""


def moved_by(
    t: Float[np.ndarray, " nodes"],
    effects: Sequence[Effect],
    r: Float[np.ndarray, "steps 3 3"],
    M: float,
) -> Float[np.ndarray, "nodes rows effects"]:
    """What each effect gives to a robot; inertial axes, SI.

    Args:
        t: times of the nodes, s.
        effects: about S.
        r: from S to the CM, m.
        M: the robot's mass, kg.
    """
    table = np.zeros((t.size, ROWS, len(effects)))
    for k, each in enumerate(effects):
        rate = each.torque
        if each.accelerates:
            rate = rate - np.cross(r, each.force, axis=2)
            felt = each.force / M + each.push
            v = integral(t, felt + each.pull)
            table[:, 6:9, k] = integral(t, by_step(v))
            table[:, 9:12, k] = v
            table[:, 12:15, k] = at_nodes(felt)
        table[:, 0:3, k], table[:, 3:6, k] = integral(t, rate), at_nodes(rate)
    return table


def moved_by_beta(
    t: Float[np.ndarray, " nodes"],
    effect: Effect,
    uneven: Float[np.ndarray, "3 3"],
    r: Float[np.ndarray, "steps 3 3"],
    moments: Float[np.ndarray, "steps 3 3 beta"],
    M: float,
) -> Float[np.ndarray, "nodes 15 beta"]:
    """The slopes of that by `beta`: of lever arms, and of how a force moves the mass.

    Args:
        t: times of the nodes, s.
        effect: all effects together, about S.
        uneven: the change of the pull with the CM's place, 1/s^2.
        r: from S to the CM, m.
        moments: the first moment about S by each `beta`.
        M: the robot's mass, kg.
    """
    by_r = moments / M
    by_r[..., 0] -= r / M
    rate = -np.cross(by_r, effect.force[..., None], axis=2)
    slopes = np.zeros((t.size, ROWS, by_r.shape[-1]))
    slopes[:, 0:3], slopes[:, 3:6] = integral(t, rate), at_nodes(rate)
    felt = -effect.force / M**2
    v = integral(t, felt)
    slopes[:, 6:9, 0], slopes[:, 9:12, 0] = integral(t, by_step(v)), v
    slopes[:, 12:15, 0] = at_nodes(felt)
    if uneven.any():
        v = integral(t, uneven @ (by_r - by_r[0, 0]))
        slopes[:, 6:9] += integral(t, by_step(v))
        slopes[:, 9:12] += v
    return slopes
