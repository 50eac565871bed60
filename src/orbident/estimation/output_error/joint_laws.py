"""Joints on springs that nobody measures, as the core follows them (Eq. 11).

Their equations stand in `passive_rates.hpp`.
"""

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.estimation.levels import ChiSquare
from orbident.estimation.solution import Prior
from orbident.estimation.unknowns import CalibrationFit, SpringFit
from orbident.model.kinematics import carried_inertia
from orbident.preprocessing.wrenches import Wrenches
from orbident.robot.description import Passive, Robot

IDEAL = 1e-7
"""rad or m: what no spring explains moves a passive joint by so much in a period.
Nothing does: it keeps continuity from weighing more than rounding allows. A hundred
times as much takes part of the place of what panels of 10 mrad show."""

HELD = 1e-6
"""Relative standard deviation of what is held."""

LOOSE = 1e-1, 1e-3, 1e-5
"""The same in the fits before the last. Where a frequency is off, the phase is off by
more and more periods, and the fit of a whole recording has many minima; that of joints
which may move nearly as they like has one, and leads to the next."""

ENOUGH = 0.01
"""Such a fit, which only leads to the next, ends with a step that lowers the cost by a
smaller part."""

FIRST_HELD = 30.0
"""What is known of carried inertias counts so many times as much in those fits. Where
joints may move nearly as they like, how far they swing and what they carry are one
unknown: searches went along it, and from there to other minima."""

EXACT = CalibrationFit(0.0, 0.0, 0.0)
"""The error of a quantity that is taken as the robot file declares it."""


class JointLaws(NamedTuple):
    """As the core takes them."""

    passive: Float[np.ndarray, " passive"]
    """Indices of joints."""
    laws: Float[np.ndarray, "passive numbers"]
    """The square of the rate at which it swings, the rate at which it is damped, what
    position and rate walk in a second, and the inertia by `theta`; SI."""


def joint_laws(robot: Robot, wrenches: Wrenches, unexplained: float) -> JointLaws:
    """The laws of a robot's passive joints.

    Args:
        robot: with its passive joints.
        wrenches: what was recorded to act.
        unexplained: what no spring explains moves them by so much in a period, rad or
            m.

    Raises:
        InputError: one carries nothing, or thrust acts.
    """
    names = [name for name in robot.joint_names if name in robot.passive]
    if names and any(each.force.any() for each in wrenches):
        raise InputError(
            f"{robot.name}: joint '{names[0]}' is passive, and thrust shakes it, which "
            "is not in its equations; use a part of the recording without thrust "
            "(--from, --to)"
        )
    laws = np.zeros((len(names), 4 + robot.theta.size))
    for law, name in zip(laws, names, strict=True):
        passive = robot.passive[name]
        rate = 2 * np.pi * passive.frequency
        walk = unexplained * np.sqrt(passive.frequency)
        law[:4] = rate**2, 2 * passive.damping * rate, walk, rate * walk
        law[4:] = carried_inertia(robot, robot.joint_names.index(name))
        if not law[4:] @ robot.theta.ravel() > 0:
            raise InputError(
                f"{robot.name}: passive joint '{name}' carries no inertia about its "
                "axis; give the bodies behind it masses"
            )
    passive = [float(robot.joint_names.index(name)) for name in names]
    return JointLaws(np.array(passive), laws)


def what_is_carried_held(prior: Prior) -> Prior:
    """What is known where what joints carry is hardly free."""
    return prior._replace(carried=FIRST_HELD * prior.carried)


def springs_of(
    robot: Robot, errors: Mapping[str, CalibrationFit]
) -> dict[str, SpringFit]:
    """How passive joints swing, from the logarithms by which they are off."""
    found = {}
    for name, declared in robot.passive.items():
        rate, damping = (
            errors.get(f"joint.{name}.{what}", EXACT)
            for what in ("frequency", "damping")
        )
        frequency = declared.frequency * math.exp(rate.value)
        share = declared.damping * math.exp(damping.value - rate.value)
        std = math.hypot(damping.std, rate.std)
        found[name] = SpringFit(frequency, frequency * rate.std, share, share * std)
    return found


def elsewhere(
    passive: Mapping[str, Passive], springs: Mapping[str, SpringFit]
) -> list[str]:
    """The joints that swing at another frequency than chance lets them.

    Args:
        passive: the joints, as the robot file has them.
        springs: how they were found to swing.
    """
    squares = {
        name: (math.log(fit.frequency / passive[name].frequency) / std) ** 2
        for name, fit in springs.items()
        if (std := passive[name].tolerance)
    }
    return [
        name
        for name, square in squares.items()
        if ChiSquare(square, 1).is_no_chance("other parameters")
    ]


def longest_interval(robot: Robot, unexplained: float) -> float:
    """Joints that move nearly as they like do so from one interval to the next, s."""
    rates = [each.frequency for each in robot.passive.values()]
    return 1 / max(rates) if rates and unexplained > IDEAL else np.inf


def fastest(robot: Robot) -> float:
    """The highest frequency of its passive joints, Hz; zero without any."""
    return max((each.frequency for each in robot.passive.values()), default=0.0)
