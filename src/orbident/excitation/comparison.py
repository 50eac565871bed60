"""Several trajectories for one robot, by every criterion."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.excitation.hats import Basis
from orbident.excitation.proof import floated
from orbident.excitation.scores import Scores, scores_of
from orbident.precision import in_float64
from orbident.regressors.minimal_sets import minimal_sets
from orbident.robot.description import Robot
from orbident.trajectories.trajectory import Trajectory


class Comparison(NamedTuple):
    """What each trajectory promises; the smaller, the better."""

    sources: tuple[str, ...]
    scores: tuple[Scores, ...]
    parameters: tuple[str, ...]
    """`M`, `pi_1` .., `phi_1` .., automatic basis."""
    nominal: Float[np.ndarray, " parameters"]
    deviations: Float[np.ndarray, "trajectories parameters"]
    """Predicted standard deviations; NaN where not all is determined."""


@in_float64
def compare(
    robot: Robot, trajectories: Sequence[Trajectory], basis: Basis | None = None
) -> Comparison:
    """Score each trajectory, with the nominal inertia and the robot file's sensors.

    Args:
        robot: with its nominal inertia.
        trajectories: each with its initial state.
        basis: of the condition numbers; the automatic one by default.

    Raises:
        InputError: a trajectory is not for this robot, or the base turns too fast.
    """
    sets = minimal_sets(robot)
    pi, phi = sets.pi(robot.theta), sets.phi(robot.theta)
    names = ["M"]
    names += [f"pi_{i + 1}" for i in range(pi.size)]
    names += [f"phi_{i + 1}" for i in range(phi.size)]
    scores, deviations = [], []
    for trajectory in trajectories:
        ordered = trajectory.for_robot(robot)
        score = scores_of(robot, ordered, floated(robot, ordered), basis)
        scores.append(score)
        std = score.deviations
        deviations.append(
            np.full(len(names), np.nan)
            if std is None
            else np.concatenate([[std.mass], std.pi, std.phi])
        )
    return Comparison(
        sources=tuple(trajectory.source for trajectory in trajectories),
        scores=tuple(scores),
        parameters=tuple(names),
        nominal=np.concatenate([[robot.mass], pi, phi]),
        deviations=np.array(deviations),
    )
