"""Which joints follow others, through however many between them."""

from collections.abc import Collection
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.robot.description import Coupling, Robot
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


class CoupledJoints(NamedTuple):
    """`q = lead q_free + offset`: all joints, of those that follow none."""

    free: list[int]
    """Which joints follow none."""
    lead: Float[np.ndarray, "joints free"]
    offset: Float[np.ndarray, " joints"]
    """rad or m."""


def coupled_joints(robot: Robot) -> CoupledJoints:
    """How the robot's joints follow those that move by themselves."""
    at = {name: k for k, name in enumerate(robot.joint_names)}
    lead, offset = np.eye(len(at)), np.zeros(len(at))
    for follower, leader, factor, shift in robot.couplings:
        lead[at[follower]] = factor * lead[at[leader]]
        offset[at[follower]] = shift
    followers = {coupling.follower for coupling in robot.couplings}
    free = [k for name, k in at.items() if name not in followers]
    return CoupledJoints(free, lead[:, free], offset)
