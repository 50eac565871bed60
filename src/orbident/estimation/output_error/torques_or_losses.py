"""Torques from outside, and momentum that wheels lose unseen, look alike.

A wheel that slows down while its recorded speed stays gives its momentum to the rest of
the robot, as a torque would. In space the two differ by how the base turns: momentum
that was lost turns with it, and what a torque has given does not. Where the recording
does not say which of them it was, deviations hold how far apart both results are.

About the vertical of a table they are the same, whatever the base does.
"""

from collections.abc import Callable, Collection, Iterator, Mapping

import numpy as np
from jaxtyping import Float

from orbident.environment.agents import IN_WORDS, STEADY
from orbident.estimation.levels import LEVELS
from orbident.estimation.output_error.disturbance_sizes import places_of
from orbident.estimation.output_error.noise_scaling import Fitted
from orbident.estimation.output_error.problem import Problem
from orbident.estimation.solution import Solution

LOSS = "wheel_loss"

TORQUES = tuple((mean, slow) for slow, mean in STEADY.items())
"""Every torque with what changes slowly of it."""


def instead(
    problem: Problem,
    first: Callable[[tuple[str, ...]], Solution],
    found: Fitted,
    groups: Collection[str],
    asked: Collection[str],
) -> dict[str, Float[np.ndarray, " beta"]]:
    """How far off `beta` is if it was the other one, by that one's group.

    The likelihood of what is wrong is more than `1 / level` times that of what is
    right with no more than that probability; every number beside what is right lowers
    chi-square by one in the mean.

    Args:
        problem: a recording's equations.
        first: finds a solution with other groups.
        found: the fit of these.
        groups: that it has among its unknowns.
        asked: those of them that the user says act.
    """
    of_torques = {group for both in TORQUES for group in both}
    alike = {*groups} & {*of_torques, LOSS}
    everything = {each.group for each in problem.acting.disturbances} if alike else ()
    if LOSS not in everything or {*asked} & {*of_torques, LOSS}:
        return {}
    left = tuple(group for group in groups if group not in alike)

    def worth(cost: float, groups: Collection[str]) -> float:
        return cost + places_of(problem, groups).size

    limit = worth(found.assumed, groups) - 2 * np.log(LEVELS["other explanation"])
    differences = {}
    for others in TORQUES if LOSS in alike else ((LOSS,),):
        other = first((*left, *others))
        if worth(other.cost, (*left, *others)) < limit:
            differences[others[-1]] = other.state.beta - found.solution.state.beta
    return differences


def instead_in_words(
    differences: Mapping[str, Float[np.ndarray, " beta"]],
) -> Iterator[str]:
    """Notes on what may act in place of what was identified, by its group."""
    for group in differences:
        yield (
            f"or else {IN_WORDS[group]}: that explains the recording as well, and "
            "deviations hold both; if you know which of them acts, say so "
            "(--disturbance), and they are narrower"
        )
