"""What becomes of a clean recording by one mistake."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from recordings import Clean, designed

from orbident.estimation.linear_fits import InitialMomentum
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.schema import TolerancesEntry


@dataclass(frozen=True, eq=False)
class Spoiled:
    """What the user has, and what the user does not know."""

    robot: Robot
    recording: Recording
    true: tuple[Robot, ...]
    """A result that is right for one of these is right."""
    initial_momentum: InitialMomentum


Spoil = Callable[[Clean], Spoiled]


def spoiled(
    clean: Clean, robot: Robot | None = None, recording: Recording | None = None
) -> Spoiled:
    return Spoiled(
        robot=designed(robot or clean.robot),
        recording=recording or clean.recorded(),
        true=(clean.robot,),
        initial_momentum=clean.initial_momentum,
    )


def nothing(clean: Clean) -> Spoiled:
    return spoiled(clean)


def tolerating(spoiled: Spoiled, tolerance: Mapping[str, Any]) -> Spoiled:
    """The same recording, with a robot file that declares this tolerance."""
    robot = spoiled.robot
    entry = TolerancesEntry.model_validate(tolerance)
    said = entry.in_si(
        robot.joints, robot.thrusters, robot.torque_constants, robot.name
    )
    known = replace(robot, tolerances=said)
    return replace(spoiled, robot=known)
