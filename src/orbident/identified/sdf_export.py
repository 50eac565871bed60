"""A robot as SDFormat, the model file of Gazebo: floating, without gravity."""

import xml.etree.ElementTree as ET

import numpy as np
from jaxtyping import Float

from orbident.identified.exported_robot import FEATURE_POINT, Mechanism, unused
from orbident.robot.description import Joint
from orbident.robot.formats.urdf_text import roll_pitch_yaw
from orbident.robot.parameters import (
    FIRST_MOMENT,
    INERTIA_ENTRIES,
    MASS,
    inertia_about_com,
)

VERSION = "1.7"
"""The first in which frames, such as that of S, mean what they do today."""


def sdf(robot: Mechanism) -> str:
    """The robot as an SDF file with one model.

    Links stand where they are at `q = 0`; the model's frame is the base link's. S is a
    frame. The base is free, in the plane too: no joint of the format holds it there.
    """
    root = ET.Element("sdf", version=VERSION)
    model = ET.SubElement(root, "model", name=robot.name)
    R, p = [np.eye(3)], [np.zeros(3)]
    for joint in robot.joints:
        R_0, p_0 = R[joint.parent], p[joint.parent]
        R.append(R_0 @ joint.R_PJ)
        p.append(p_0 + R_0 @ joint.p_PJ)
    for k, name in enumerate(robot.bodies):
        link = ET.SubElement(model, "link", name=name)
        _add(link, "pose", [*p[k], *roll_pitch_yaw(R[k])])
        ET.SubElement(link, "gravity").text = "false"
        _add_mass(link, robot.theta[k])
    # Links, joints and frames share their names.
    taken = [*robot.bodies]
    for joint, child in zip(robot.joints, robot.bodies[1:], strict=True):
        taken.append(unused(joint.name, taken))
        parent = robot.bodies[joint.parent]
        _add_joint(model, taken[-1], joint, parent, child)
    name = unused(FEATURE_POINT, taken)
    S = ET.SubElement(model, "frame", name=name, attached_to=robot.bodies[0])
    _add(S, "pose", [*robot.feature_point, 0, 0, 0])
    ET.indent(root)
    return ET.tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def _add_mass(link: ET.Element, theta: Float[np.ndarray, "10"]) -> None:
    inertial = ET.SubElement(link, "inertial")
    _add(inertial, "pose", [*(theta[FIRST_MOMENT] / theta[MASS]), 0, 0, 0])
    _add(inertial, "mass", [theta[MASS]])
    inertia, I = ET.SubElement(inertial, "inertia"), inertia_about_com(theta)
    for a, b in INERTIA_ENTRIES:
        _add(inertia, f"i{'xyz'[a]}{'xyz'[b]}", [I[a, b]])


def _add_joint(
    model: ET.Element, name: str, joint: Joint, parent: str, child: str
) -> None:
    element = ET.SubElement(model, "joint", name=name, type=joint.kind)
    ET.SubElement(element, "parent").text = parent
    ET.SubElement(element, "child").text = child
    axis = ET.SubElement(element, "axis")
    _add(axis, "xyz", joint.axis)
    limit = ET.SubElement(axis, "limit")
    # Without limits these are those of the format.
    low, high = joint.position or (-1e16, 1e16)
    _add(limit, "lower", [low])
    _add(limit, "upper", [high])
    if joint.velocity is not None:
        _add(limit, "velocity", [joint.velocity])


def _add(parent: ET.Element, tag: str, numbers: object) -> None:
    words = (repr(float(x)) for x in np.asarray(numbers))
    ET.SubElement(parent, tag).text = " ".join(words)
