"""Which joints follow others, through however many between them."""

from collections.abc import Collection

from orbident.errors import InputError
from orbident.robot.description import Coupling
from orbident.robot.urdf import Urdf


def couplings_of(
    urdf: Urdf, moving: Collection[str]
) -> tuple[tuple[Coupling, ...], list[str]]:
    """The couplings of a robot's joints.

    Args:
        urdf: its joints say what they mimic.
        moving: the names of the robot's joints.

    Returns:
        Couplings to joints that follow none, and a warning for each joint that follows
        what does not move.

    Raises:
        InputError: joints follow each other in a circle.
    """
    mimics = {joint.name: joint.mimic for joint in urdf.joints}
    couplings, warnings = [], []
    for name in moving:
        leader, factor, offset = name, 1.0, 0.0
        passed = [name]
        while (mimic := mimics[leader]) is not None:
            # q = factor (multiplier q' + mimic.offset) + offset
            offset += factor * mimic.offset
            factor *= mimic.multiplier
            leader = mimic.joint
            if leader in passed:
                raise InputError(
                    f"{urdf.place}: joint '{name}' mimics itself by way of '{leader}'; "
                    "take out one <mimic>"
                )
            passed.append(leader)
        if leader == name:
            continue
        if leader in moving:
            couplings.append(Coupling(name, leader, factor, offset))
        else:
            warnings.append(
                f"joint '{name}' mimics '{leader}', which is no joint that moves here: "
                "it is taken as independent"
            )
    return tuple(couplings), warnings
