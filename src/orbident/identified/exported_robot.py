"""The identified robot as other tools want it: bodies that can exist, wheels apart.

A robot counts its wheels in the base (Eq. 5); other tools' wheels are bodies. A wheel
that is a joint of the URDF has the mass and the place that its links have there. Of a
wheel that is only declared the polar inertia is known, and nothing else matters: it is
taken as a ball with this inertia, at the CM of the nominal base, so that the base loses
little else. Its URDF has other inertias, and is read again as proof that it means them.
"""

import xml.etree.ElementTree as ET
from collections.abc import Collection, Iterable
from dataclasses import replace
from itertools import count
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.estimation.result import Result
from orbident.files.schema_parts import validated
from orbident.identified.physical import physical_bodies
from orbident.model.core_robot import (
    lacking_rotors,
    rotor_deviations,
    rotors_of,
    spinning_parts,
    theta_with_rotors,
)
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import Friction, Joint, Robot, Wheel
from orbident.robot.fusing import LinkTree, Placement, fused, link_tree
from orbident.robot.joint_schema import make_stiff, parsed
from orbident.robot.oddities import nonphysical
from orbident.robot.parameters import (
    FIRST_MOMENT,
    MASS,
    PER_BODY,
    from_mass_com_inertia,
    inertia_about_com,
    transformed,
)
from orbident.robot.robot_file import assembled
from orbident.robot.schema import RobotFile
from orbident.robot.urdf import inertial_element
from orbident.robot.urdf_reader import read_urdf

PLACE = "exported URDF"
NO_ROTORS = "the declared rotors of motors are in the robot file alone, not in bodies"
SAME = 1e-9
"""Relative difference of base parameters that are the same but for rounding."""


def links_of(robot: Robot) -> tuple[LinkTree, dict[str, Placement]]:
    """The URDF's links behind a robot's bodies, and where each is in its body.

    The base's frame is the base link's, not at S.

    Raises:
        InputError: the robot was not loaded from a URDF.
    """
    if not robot.urdf:
        raise InputError(
            f"robot '{robot.name}' was not loaded from a URDF; nothing can be exported"
        )
    file = validated(RobotFile, dict(robot.document), robot.name)
    tree = link_tree(read_urdf(robot.urdf, robot.name), file.base_link)
    held = frozenset(wheel.joint for wheel in file.wheels if wheel.joint is not None)
    return tree, fused(tree, held=held).placements


def exported_urdf(robot: Robot) -> str:
    """The robot's URDF with the inertias of its `theta`.

    Links that are fixed to a body become massless. Wheels that are links of their own
    keep their inertia, which `theta` has in it. Flexible joints are stiff, as in the
    URDF that the robot file names. `theta` is of bodies that can exist, without their
    wheels too; the rotors of geared motors are not in it.

    Raises:
        InputError: the robot was not loaded from a URDF, or what was written does not
            read back with the same base parameters.
    """
    (_, placements), wheels = links_of(robot), wheel_joints(robot).values()
    turning = {link for wheel in wheels for link in wheel.links}
    own = robot.theta - parts_of_base(robot, wheels)
    own[0] = transformed(own[0], np.eye(3), robot.feature_point)
    root = parsed(robot.urdf)
    for link in root.findall("link"):
        name = link.get("name", "")
        if name not in placements or name in turning:
            continue
        for inertial in link.findall("inertial"):
            link.remove(inertial)
        # Explicit zeros: where there is no inertial, MuJoCo weighs the geometry.
        carries = name in robot.bodies
        theta_link = own[robot.bodies.index(name)] if carries else np.zeros(PER_BODY)
        m = theta_link[MASS]
        I = inertia_about_com(theta_link) if m else np.zeros((3, 3))
        link.insert(0, inertial_element(m, theta_link[FIRST_MOMENT] / (m or 1.0), I))
    for joint in root.findall("joint"):
        if friction := robot.friction.get(joint.get("name", "")):
            dynamics = joint.find("dynamics")
            if dynamics is None:
                dynamics = ET.SubElement(joint, "dynamics")
            dynamics.set("damping", repr(friction.viscous))
            dynamics.set("friction", repr(friction.coulomb))
    add_comment(root, lacking_rotors(robot, NO_ROTORS))
    _check_read_back(robot, ET.tostring(root, encoding="unicode"))
    make_stiff(root)
    ET.indent(root)
    return ET.tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def add_comment(root: ET.Element, words: str) -> None:
    """Begin a model's XML with a comment, if there is something to say."""
    if words:
        # XML allows no two hyphens there.
        root.insert(0, ET.Comment(f" {words.replace('--', '- -')} "))


def _check_read_back(robot: Robot, text: str) -> None:
    document = dict(robot.document)
    file = validated(RobotFile, document, PLACE)
    again = assembled(file, document, read_urdf(text, PLACE), text, PLACE)
    sets = minimal_sets(robot)
    meant, found = sets.beta(robot.theta), sets.beta(again.theta)
    off = np.abs(found - meant).max() / np.abs(meant).max()
    if not off <= SAME:
        raise InputError(
            f"{robot.name}: the URDF reads back with base parameters that are off by "
            f"{off:.2g}; report this with the RUN folder"
        )


LIGHT = 1e-3
"""A declared wheel's part of the robot's mass: no motion depends on it."""


class WheelJoint(NamedTuple):
    """A wheel that is a joint of the URDF."""

    root: str
    """The link that the joint turns,"""
    links: frozenset[str]
    """and all links that turn with it."""
    p: Float[np.ndarray, "3"]
    """Where its joint is from S, base axes, m."""
    theta: Float[np.ndarray, "10"]
    """Inertial parameters of `links` about the joint, base axes, at wheel angle 0."""


class WheelBody(NamedTuple):
    """A wheel as a body that turns about its axis through its origin."""

    name: str
    p: Float[np.ndarray, "3"]
    """Its origin from S, base axes, m."""
    theta: Float[np.ndarray, "10"]
    """About its origin, base axes, at a wheel angle of zero."""


def wheel_joints(robot: Robot) -> dict[int, WheelJoint]:
    """Wheels that the URDF has as joints, by the index of the wheel."""
    entries = enumerate(robot.document.get("wheels", ()))
    joints = {entry["joint"]: k for k, entry in entries if "joint" in entry}
    if not joints:
        return {}
    tree, placements = links_of(robot)
    found = {}
    for joint in (each for below in tree.children.values() for each in below):
        if joint.name in joints:
            wheel, at = fused(tree, joint.child), placements[joint.child]
            found[joints[joint.name]] = WheelJoint(
                joint.child,
                frozenset(wheel.placements),
                at.p - robot.feature_point,
                transformed(wheel.theta[0], at.R, np.zeros(3)),
            )
    return found


def parts_of_base(
    robot: Robot, wheels: Iterable[WheelJoint | WheelBody]
) -> Float[np.ndarray, "bodies 10"]:
    """What the wheels add to each body's `theta`: to the base alone."""
    parts = np.zeros_like(robot.theta)
    for wheel in wheels:
        parts[0] += transformed(wheel.theta, np.eye(3), wheel.p)
    return parts


def _wheel_body(robot: Robot, wheel: Wheel, joint: WheelJoint | None) -> WheelBody:
    """The wheel as a body that can exist."""
    ball = from_mass_com_inertia(
        LIGHT * robot.mass, np.zeros(3), wheel.inertia * np.eye(3)
    )
    if joint is None:
        m = robot.theta[0, MASS]
        at_com = robot.theta[0, FIRST_MOMENT] / m if m > 0 else np.zeros(3)
        return WheelBody(f"{wheel.name}_rotor", at_com, ball)
    m = joint.theta[MASS]
    # What a URDF says of a wheel need not be possible.
    possible = m > 0 and not nonphysical(wheel.name, m, inertia_about_com(joint.theta))
    return WheelBody(joint.root, joint.p, joint.theta if possible else ball)


NO_ARMATURE = (
    "bodies hold the declared rotors as momentum sees them, but joints lack "
    "gear (gear - 1) times their inertia, for which this format has no place"
)
"""What is said of rotors in such a format."""

WITH_ROTORS = (
    ", or export a .urdf: thin links cannot hold what motors' rotors add to momentum"
)

FEATURE_POINT = "feature_point"
"""The name of S in a file for another tool."""


class NoBodiesError(InputError):
    """No bodies that can exist have the identified parameters."""


class Mechanism(NamedTuple):
    """A tree of bodies, where each wheel is a joint and a body after the others.

    The base has the frame of the base link, all others that of their joint. Joint `k`
    moves body `k + 1`.
    """

    robot: Robot
    """The identified robot: wheels are counted in the base, and rotors are apart."""
    bodies: tuple[str, ...]
    joints: tuple[Joint, ...]
    theta: Float[np.ndarray, "bodies 10"]
    armature: Float[np.ndarray, " joints"]
    """What declared rotors add to each joint's own inertia beside `theta`, kg m^2."""
    deviation: float = 0.0
    """How far the base parameters were moved so that bodies can exist, in sigmas."""


def exported_robot(result: Result, without_rotors: bool = False) -> Mechanism:
    """Bodies that have the identified parameters, nearest to the nominal ones.

    The result is complete and not rejected. Bodies are to exist without the declared
    rotors of motors, or with them as momentum sees them.

    Raises:
        NoBodiesError: no bodies that can exist have the identified parameters within
            their 95 % region.
        InputError: the result is rejected or not complete, the robot was not loaded
            from a URDF, a simulator's body has no mass, or cvxpy is not installed.
    """
    robot = result.robot
    massless = [body for body, each in robot.structure.items() if not each.has_mass]
    if massless and not without_rotors:
        none = f"simulators have no bodies without mass, such as '{massless[0]}'"
        raise InputError(f"{robot.name}: {none}; export a .urdf")
    joints = wheel_joints(robot)
    wheels = tuple(
        _wheel_body(robot, wheel, joints.get(k)) for k, wheel in enumerate(robot.wheels)
    )
    apart, covariance = parts_of_base(robot, wheels), result.base_covariance
    geared = theta_with_rotors(robot) - robot.theta
    if without_rotors:
        off = minimal_sets(robot).base.T @ rotor_deviations(robot)
        apart, covariance = apart + geared, covariance + off @ off.T
    bodies = physical_bodies(result, apart, covariance)
    if bodies is None:
        held = geared.any() and not without_rotors
        raise NoBodiesError(
            "no bodies that can exist have the identified parameters within their "
            "95 % region; check the robot's geometry, structure and rotors, or record "
            "a richer trajectory" + (WITH_ROTORS if held else "")
        )
    # What is found below zero is noise, and simulators refuse it.
    found = {
        name: Friction(max(fit.viscous, 0.0), max(fit.coulomb, 0.0), fit.offset)
        for name, fit in result.drives.items()
    }
    friction = {**robot.friction, **found}
    theta = bodies.theta - geared
    theta = theta - spinning_parts(robot, theta)
    made = replace(robot, theta=theta, friction=friction)
    return mechanism_of(made, wheels)._replace(deviation=bodies.deviation)


def mechanism_of(robot: Robot, wheels: tuple[WheelBody, ...]) -> Mechanism:
    """The robot with its wheels apart.

    Its base can exist without its wheels, which are in their order; rotors are apart.
    """
    p = robot.feature_point
    bodies, names = list(robot.bodies), list(robot.joint_names)
    joints = [
        replace(joint, p_PJ=joint.p_PJ + p) if joint.parent == 0 else joint
        for joint in robot.joints
    ]
    theta = theta_with_rotors(robot) - parts_of_base(robot, wheels)
    theta[0] = transformed(theta[0], np.eye(3), p)
    for wheel, body in zip(robot.wheels, wheels, strict=True):
        bodies.append(unused(body.name, bodies))
        names.append(unused(wheel.name, names))
        at = Joint(names[-1], "revolute", 0, wheel.axis, np.eye(3), body.p + p)
        joints.append(at)
    theta = np.vstack([theta, *(wheel.theta for wheel in wheels)])
    armature = np.zeros(len(joints))
    armature[: len(robot.joints)] = rotors_of(robot).armature
    return Mechanism(robot, tuple(bodies), tuple(joints), theta, armature)


def unused(name: str, taken: Collection[str]) -> str:
    """The name, with a number behind it where it is taken."""
    if name not in taken:
        return name
    return next(new for k in count(2) if (new := f"{name}_{k}") not in taken)
