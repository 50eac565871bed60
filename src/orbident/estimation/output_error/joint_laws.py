"""The joints whose own equations are among those of a recording (Eq. 11).

Their form in momenta, without accelerations, stands in `joint_equations.hpp`.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.model.springs import carried_inertia
from orbident.robot.description import Robot

PER_PERIOD = 12
"""Intervals in which a passive joint swings once: the collocation, of fourth order,
gives its frequency within 1e-4 then."""

IDEAL = 1e-5
"""rad or m: a torque that no spring explains moves a passive joint by so much in a
period. Nothing does: it keeps equations from weighing more than rounding allows."""


FIRST, LONGER = 2.0, 4.0
"""Periods that are followed at first, and by what factor more in each next fit: a
frequency that is off by a fifth is off by less than half a period in two."""

FORGOTTEN = 1e6
"""By how much more a joint's equations may fail where its state is anew unknown."""


class JointLaws(NamedTuple):
    """As the core takes them."""

    with_law: Float[np.ndarray, " laws"]
    """Indices of joints."""
    laws: Float[np.ndarray, "laws numbers"]
    """The square of the rate at which it swings, the rate at which it is damped, the
    density of the torque that is not explained, and the inertia by `theta`; SI."""
    slack: Float[np.ndarray, " intervals"]
    """By how much more than elsewhere they may fail."""


def joint_laws(
    robot: Robot, boundaries: Float[np.ndarray, " boundaries"], memory: float
) -> JointLaws:
    """The laws of a robot's passive joints.

    Args:
        robot: with its passive joints.
        boundaries: times at which intervals meet, s.
        memory: after so long, s, a joint's state is anew unknown.
    """
    parts = (boundaries - boundaries[0]) // memory
    slack = np.where(np.diff(parts) > 0, FORGOTTEN, 1.0)
    names = [name for name in robot.joint_names if name in robot.passive]
    laws = np.zeros((len(names), 3 + robot.theta.size))
    for law, name in zip(laws, names, strict=True):
        passive = robot.passive[name]
        inertia = carried_inertia(robot, robot.joint_names.index(name))
        rate = 2 * np.pi * passive.frequency
        density = IDEAL * (inertia @ robot.theta.ravel()) * rate
        law[0], law[1] = rate**2, 2 * passive.damping * rate
        law[2], law[3:] = density * np.sqrt(passive.frequency), inertia
    with_law = np.array([robot.joint_names.index(name) for name in names], dtype=float)
    return JointLaws(with_law, laws, slack)


def memories(robot: Robot, duration: float) -> Iterator[float]:
    """How long the springs are followed at once, by one fit after another, s.

    Where a frequency is off, the phase is off by more and more periods, and the fit of a
    whole recording has many minima. That of a few periods has one; from there the next
    one follows them for longer.

    Args:
        robot: with its passive joints.
        duration: of the recording, s.
    """
    slowest = min((each.frequency for each in robot.passive.values()), default=np.inf)
    memory = FIRST / slowest
    while memory < duration and robot.passive:
        yield memory
        memory *= LONGER


def longest_interval(robot: Robot) -> float:
    """How long an interval may be for its passive joints to be followed, s."""
    rates = (each.frequency for each in robot.passive.values())
    return min((1 / (PER_PERIOD * rate) for rate in rates), default=np.inf)
