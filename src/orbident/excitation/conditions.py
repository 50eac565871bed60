"""What an exciting trajectory has to keep to."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.excitation.hats import Basis
from orbident.excitation.limits import Limits, limits_of
from orbident.excitation.start import usual_initial
from orbident.robot.description import Robot
from orbident.trajectories.trajectory import InitialState, Trajectory

CROWDED = 0.01
"""Of its range: a joint closer to a stop has no room to move in."""


@dataclass(frozen=True, eq=False)
class Conditions:
    """What a trajectory has to keep to."""

    duration: float
    """s."""
    harmonics: int
    limits: Limits
    start: Float[np.ndarray, "joints 3"]
    """Position, velocity and acceleration of each joint at t = 0."""
    end: Float[np.ndarray, "joints 3"]
    initial: InitialState
    basis: Basis | None = None
    """Whose condition number is meant; the automatic one by default."""


def conditions_for(
    robot: Robot,
    duration: float,
    harmonics: int = 3,
    limits: Limits | None = None,
    like: Trajectory | None = None,
) -> Conditions:
    """The usual conditions: from rest at q = 0 to rest at q = 0, in the limits.

    A joint that cannot stand at zero, or at the end of its range only, starts and ends
    in the middle of it.

    Args:
        robot: with its limits.
        duration: s.
        harmonics: N_f.
        limits: those of the robot file by default.
        like: takes its ends and its initial state from this trajectory.

    Raises:
        InputError: the duration is not positive, there is no harmonic, or the limits
            or the trajectory are not for this robot.
    """
    if not 0 < duration < np.inf:
        raise InputError(
            f"duration: found {duration:g}; give a positive number of seconds"
        )
    if harmonics < 1:
        raise InputError(f"harmonics: found {harmonics}; give one or more")
    limits = limits_of(robot) if limits is None else limits
    if like is None:
        start = end = _usual_ends(limits)
        initial = usual_initial(robot, start)
    else:
        like = like.for_robot(robot)
        start, end, initial = like.start, like.end, like.initial
    return Conditions(duration, harmonics, limits, start, end, initial)


def _usual_ends(limits: Limits) -> Float[np.ndarray, "joints 3"]:
    """Position, velocity and acceleration at either end."""
    lower, upper = limits.position.T
    ends = np.zeros((len(lower), 3))
    crowded = np.minimum(-lower, upper) < CROWDED * (upper - lower)
    ends[crowded, 0] = limits.position[crowded].mean(axis=1)
    return ends
