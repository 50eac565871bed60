"""The identified robot as other tools want it: bodies that can exist, wheels apart."""

from collections.abc import Collection
from dataclasses import replace
from itertools import count
from typing import Literal, NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.estimation.result import Result
from orbident.identified.physical import physical_bodies
from orbident.identified.rotors import RotorBody, parts_of_base, rotor_bodies
from orbident.robot.description import Coupling, Joint, Robot
from orbident.robot.parameters import transformed

FEATURE_POINT = "feature_point"
"""The name of S in a file for another tool."""


class NoBodiesError(InputError):
    """No bodies that can exist have the identified parameters."""


class Mechanism(NamedTuple):
    """A tree of bodies, where each wheel is a joint and a body after the others.

    The base has the frame of the base link, all others that of their joint. Joint `k`
    moves body `k + 1`.
    """

    name: str
    motion: Literal["spatial", "planar"]
    bodies: tuple[str, ...]
    joints: tuple[Joint, ...]
    theta: Float[np.ndarray, "bodies 10"]
    feature_point: Float[np.ndarray, "3"]
    """S in the base's frame, m."""
    couplings: tuple[Coupling, ...]


class ExportedRobot(NamedTuple):
    """The identified robot, in both ways to count its wheels."""

    robot: Robot
    """Wheels are counted in the base."""
    mechanism: Mechanism
    """Wheels are bodies."""
    deviation: float
    """How far the base parameters were moved so that bodies can exist, in sigmas."""


def exported_robot(result: Result) -> ExportedRobot:
    """Bodies that have the identified parameters, nearest to the nominal ones.

    Args:
        result: complete and not rejected.

    Raises:
        NoBodiesError: no bodies that can exist have the identified parameters within
            their 95 % region.
        InputError: the result is rejected or not complete, the robot was not loaded
            from a URDF, or cvxpy is not installed.
    """
    robot = result.robot
    rotors = rotor_bodies(robot)
    bodies = physical_bodies(result, parts_of_base(robot, rotors))
    if bodies is None:
        raise NoBodiesError(
            "no bodies that can exist have the identified parameters within their "
            "95 % region; check the robot's geometry and structure, or record a richer "
            "trajectory"
        )
    made = replace(robot, theta=bodies.theta)
    return ExportedRobot(made, mechanism_of(made, rotors), bodies.deviation)


def mechanism_of(robot: Robot, rotors: tuple[RotorBody, ...]) -> Mechanism:
    """The robot with its wheels apart.

    Args:
        robot: whose base can exist without its wheels.
        rotors: its wheels, in their order.
    """
    p = robot.feature_point
    bodies, names = list(robot.bodies), list(robot.joint_names)
    joints = [
        replace(joint, p_PJ=joint.p_PJ + p) if joint.parent == 0 else joint
        for joint in robot.joints
    ]
    theta = robot.theta - parts_of_base(robot, rotors)
    theta[0] = transformed(theta[0], np.eye(3), p)
    for wheel, rotor in zip(robot.wheels, rotors, strict=True):
        bodies.append(unused(rotor.name, bodies))
        names.append(unused(wheel.name, names))
        at = Joint(names[-1], "revolute", 0, wheel.axis, np.eye(3), rotor.p + p)
        joints.append(at)
    theta = np.vstack([theta, *(rotor.theta for rotor in rotors)])
    tree = tuple(bodies), tuple(joints), theta
    return Mechanism(robot.name, robot.motion, *tree, p, robot.couplings)


def unused(name: str, taken: Collection[str]) -> str:
    """The name, with a number behind it where it is taken."""
    if name not in taken:
        return name
    return next(new for k in count(2) if (new := f"{name}_{k}") not in taken)
