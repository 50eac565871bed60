"""What becomes of a clean recording by one mistake."""

from collections.abc import Callable
from dataclasses import dataclass

from recordings import Clean, designed

from orbident.estimation.linear_fits import InitialMomentum
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot


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
