"""Joints on springs that nobody measures, as the core follows them (Eq. 11).

Their equations stand in `passive_joints.hpp`.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.model.springs import carried_inertia
from orbident.robot.description import Robot

IDEAL = 1e-5
"""rad or m: what no spring explains moves a passive joint by so much in a period.
Nothing does: it keeps continuity from weighing more than integration allows."""

FIRST, LONGER = 2.0, 4.0
"""Periods that are followed at first, and by what factor more in each next fit: a
frequency that is off by a fifth is off by less than half a period in two."""

FORGOTTEN = 1e6
"""By how much more a joint walks where its state is anew unknown."""


class JointLaws(NamedTuple):
    """As the core takes them."""

    passive: Float[np.ndarray, " passive"]
    """Indices of joints."""
    laws: Float[np.ndarray, "passive numbers"]
    """The square of the rate at which it swings, the rate at which it is damped, what
    position and rate walk in a second, and the inertia by `theta`; SI."""
    slack: Float[np.ndarray, " intervals"]
    """By how much more than elsewhere they walk."""


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
    laws = np.zeros((len(names), 4 + robot.theta.size))
    for law, name in zip(laws, names, strict=True):
        passive = robot.passive[name]
        rate = 2 * np.pi * passive.frequency
        walk = IDEAL * np.sqrt(passive.frequency)
        law[:4] = rate**2, 2 * passive.damping * rate, walk, rate * walk
        law[4:] = carried_inertia(robot, robot.joint_names.index(name))
    passive = np.array([robot.joint_names.index(name) for name in names], dtype=float)
    return JointLaws(passive, laws, slack)


def memories(robot: Robot, duration: float) -> Iterator[float]:
    """How long the springs are followed at once, by one fit after another, s.

    Where a frequency is off, the phase is off by more and more periods, and the fit of
    a whole recording has many minima. That of a few periods has one; from there the
    next one follows them for longer.

    Args:
        robot: with its passive joints.
        duration: of the recording, s.
    """
    memory = FIRST / fastest(robot) if robot.passive else np.inf
    while memory < duration:
        yield memory
        memory *= LONGER


def fastest(robot: Robot) -> float:
    """The highest frequency of its passive joints, Hz; zero without any."""
    return max((each.frequency for each in robot.passive.values()), default=0.0)
