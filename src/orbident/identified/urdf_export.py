"""A robot's URDF with other inertias, and the proof that it means them."""

import xml.etree.ElementTree as ET
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.files.schema_parts import validated
from orbident.model.core_robot import lacking_rotors
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import Robot
from orbident.robot.formats.urdf_text import inertial_element
from orbident.robot.fusing import Placement, fused
from orbident.robot.parameters import (
    FIRST_MOMENT,
    MASS,
    PER_BODY,
    inertia_about_com,
    transformed,
)
from orbident.robot.robot_file import assembled
from orbident.robot.schema import RobotFile
from orbident.robot.tree import LinkTree, link_tree
from orbident.robot.urdf import read_urdf

PLACE = "exported URDF"
NO_ROTORS = "the declared rotors of motors are in the robot file alone, not in bodies"
SAME = 1e-9
"""Relative difference of base parameters that are the same but for rounding."""


class Links(NamedTuple):
    """Where the URDF's links are in the bodies of the robot."""

    tree: LinkTree
    placements: dict[str, Placement]
    """Where each link is in its body; the base's frame is the base link's, not at S."""
    wheels: frozenset[str]
    """Links that turn with a wheel."""


def links_of(robot: Robot) -> Links:
    """The links behind a robot's bodies.

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
    roots = [
        joint.child
        for below in tree.children.values()
        for joint in below
        if joint.name in held
    ]
    wheels = [link for root in roots for link in fused(tree, root).placements]
    return Links(tree, fused(tree, held=held).placements, frozenset(wheels))


def wheel_parts(robot: Robot) -> Float[np.ndarray, "bodies 10"]:
    """What the wheels that are links of their own add to each body's `theta`.

    Raises:
        InputError: the robot was not loaded from a URDF.
    """
    links = links_of(robot)
    parts = np.zeros_like(robot.theta)
    for name in links.wheels:
        at = links.placements[name]
        p = at.p - robot.feature_point
        parts[at.body] += transformed(links.tree.links[name].theta, at.R, p)
    return parts


def exported_urdf(robot: Robot, theta: Float[np.ndarray, "bodies 10"]) -> str:
    """The robot's URDF with the inertias of `theta`.

    Links that are fixed to a body lose theirs, become massless. The
    wheels that are links of their own keep theirs, which `theta` has in it.

    Args:
        robot: loaded from a URDF.
        theta: of bodies that can exist, without their wheels too; the rotors of geared
            motors are not in it.

    Raises:
        InputError: the robot was not loaded from a URDF, or what was written does not
            read back with the same base parameters.
    """
    links = links_of(robot)
    own = theta - wheel_parts(robot)
    own[0] = transformed(own[0], np.eye(3), robot.feature_point)
    root = ET.fromstring(
        robot.urdf, ET.XMLParser(target=ET.TreeBuilder(insert_comments=True))
    )
    for link in root.findall("link"):
        name = link.get("name", "")
        if name not in links.placements or name in links.wheels:
            continue
        for inertial in link.findall("inertial"):
            link.remove(inertial)
        # Explicit zeros: where there is no inertial, MuJoCo weighs the geometry.
        carries = name in robot.bodies
        theta_link = own[robot.bodies.index(name)] if carries else np.zeros(PER_BODY)
        m = theta_link[MASS]
        com = theta_link[FIRST_MOMENT] / (m or 1.0)
        I = inertia_about_com(theta_link) if m else np.zeros((3, 3))
        link.insert(0, inertial_element(m, com, I))
    for joint in root.findall("joint"):
        if friction := robot.friction.get(joint.get("name", "")):
            dynamics = joint.find("dynamics")
            if dynamics is None:
                dynamics = ET.SubElement(joint, "dynamics")
            dynamics.set("damping", repr(friction.viscous))
            dynamics.set("friction", repr(friction.coulomb))
    add_comment(root, lacking_rotors(robot, NO_ROTORS))
    ET.indent(root)
    text = ET.tostring(root, encoding="unicode", xml_declaration=True) + "\n"
    _check_read_back(robot, theta, text)
    return text


def add_comment(root: ET.Element, words: str) -> None:
    """Begin a model's XML with a comment, if there is something to say."""
    if words:
        # XML allows no two hyphens there.
        root.insert(0, ET.Comment(f" {words.replace('--', '- -')} "))


def _check_read_back(
    robot: Robot, theta: Float[np.ndarray, "bodies 10"], text: str
) -> None:
    document = dict(robot.document)
    file = validated(RobotFile, document, PLACE)
    again = assembled(file, document, read_urdf(text, PLACE), text, PLACE)
    sets = minimal_sets(robot)
    meant, found = sets.beta(theta), sets.beta(again.theta)
    off = np.abs(found - meant).max() / np.abs(meant).max()
    if not off <= SAME:
        raise InputError(
            f"{robot.name}: the URDF reads back with base parameters that are off by "
            f"{off:.2g}; report this with the RUN folder"
        )
