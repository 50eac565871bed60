"""Joints on springs that nobody measures, as the core follows them (Eq. 11).

Their equations stand in `passive_rates.hpp`.
"""

import math
from collections.abc import Collection, Iterator, Mapping
from itertools import combinations
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.estimation.checks import Check
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

ALIKE_SPRINGS = 0.15
"""Two passive joints swing alike where the logarithm of the ratio of their frequencies
is less: with 0.3 and 0.35 Hz results hold, with equal ones they do not."""

SURELY_APART = 30.0
"""Deviations by which that logarithm must differ from zero. The recording shows its
square `s`: its own deviation is `std(s) / 2 sqrt(s)`, and first order holds from 15 of
those of `s`. Two equal panels were found to be apart by eight; those at 1 and 0.8 Hz,
apart by 22, had frequencies 1.5 % off."""

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


def turned_by(robot: Robot, locked: Collection[str]) -> dict[str, str]:
    """The measured joint that turns a passive one about its own axis, by the latter.

    Args:
        robot: with its passive joints.
        locked: names of joints that did not move.
    """
    found = {}
    for joint in robot.joints:
        before = robot.joints[joint.parent - 1]
        along = abs(before.axis @ joint.R_PJ @ joint.axis)
        if joint.name in robot.passive and joint.parent and np.isclose(along, 1.0):
            found[joint.name] = before.name
    still = {*robot.passive, *locked}
    return {name: motor for name, motor in found.items() if motor not in still}


def what_swings(
    passive: Mapping[str, Passive],
    springs: Mapping[str, SpringFit],
    carried: ChiSquare,
    turned: Mapping[str, str],
) -> Iterator[Check]:
    """Whether passive joints swing and carry as they may, and no two of them alike.

    What tells the parameters of two apart that do shows in second order, and deviations
    are of first order. Joints of one make are alike beforehand, and the motions of two
    motors tell apart the joints that they turn.

    Args:
        passive: the joints, as the robot file has them.
        springs: how they were found to swing.
        carried: how far what they carry is from what was known of it beforehand.
        turned: see `turned_by`.
    """
    for name in elsewhere(passive, springs):
        yield Check(
            "what swings",
            "do not trust",
            f"joint '{name}' swings at {springs[name].frequency:.3g} Hz or does not "
            f"bend at all: nothing near {passive[name].frequency:.3g} Hz explains the "
            "recording",
            "declare the frequency that a test shows; what is stiff is neither "
            "'passive' nor 'flexible'",
        )
    if carried.is_no_chance("other parameters"):
        yield Check(
            "what swings",
            "do not trust",
            "what passive joints carry is not what their nominal inertias say: by "
            f"{carried.value**0.5:.2g} of the deviations beforehand",
            "check masses and places of what swings, or say how well its inertia is "
            "known (passive: JOINT: inertia in the robot file)",
        )
    for one, other in combinations(springs, 2):
        of_one_make = len({passive[name].like or name for name in (one, other)}) == 1
        two_motors = len({None, turned.get(one), turned.get(other)}) == 3
        fits = springs[one], springs[other]
        apart = abs(np.log(fits[0].frequency / fits[1].frequency))
        std = sum(fit.frequency_std / fit.frequency for fit in fits)
        enough = max(ALIKE_SPRINGS, SURELY_APART * std)
        if apart < enough and not (of_one_make or two_motors):
            yield Check(
                "alike springs",
                "do not trust",
                f"joints '{one}' and '{other}' swing alike, or may: what tells apart "
                "what they carry is known far worse than deviations say",
                f"if they are of one make, say so (passive: {other}: {{like: {one}}}); "
                "else measure one of them",
                apart,
                enough,
            )
            return


def longest_interval(robot: Robot, unexplained: float) -> float:
    """Joints that move nearly as they like do so from one interval to the next, s."""
    rates = [each.frequency for each in robot.passive.values()]
    return 1 / max(rates) if rates and unexplained > IDEAL else np.inf


def fastest(robot: Robot) -> float:
    """The highest frequency of its passive joints, Hz; zero without any."""
    return max((each.frequency for each in robot.passive.values()), default=0.0)
