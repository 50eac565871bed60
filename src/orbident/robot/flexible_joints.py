"""Joints that give way between motor and link, written as two joints.

The encoder of such a joint is on its motor's side. Behind it stands a passive joint
about the same axis, and the body between both has no mass: everything else knows
passive joints alone.
"""

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from typing import Any

from orbident.errors import InputError
from orbident.files.names import suggestion

TURNING = ("revolute", "continuous")
"""The kinds of joints that may give way."""


BEHIND = "'s flexibility"
"""What the name of the passive joint has after that of the measured one."""


MOTOR = "'s motor"
"""What the name of the body between both has after that of the measured joint."""


def parsed(urdf: str) -> ET.Element:
    """A URDF's text with its comments."""
    return ET.fromstring(
        urdf, ET.XMLParser(target=ET.TreeBuilder(insert_comments=True))
    )


def flexibility(joint: str) -> str:
    """The name of the passive joint behind a measured one."""
    return f"{joint}{BEHIND}"


def with_flexible_joints(
    document: Mapping[str, Any], urdf: str, place: str
) -> tuple[dict[str, Any], str]:
    """The robot file and the URDF with passive joints in place of flexible ones.

    Args:
        document: the robot file as read, which was checked.
        urdf: the text of its URDF, which was checked.
        place: the robot file's name, for messages.

    Raises:
        InputError: a flexible joint does not turn, or is passive too.
    """
    root = parsed(urdf)
    joints = {
        joint.get("name", ""): joint
        for joint in root.findall("joint")
        if joint.get("type") in TURNING
    }
    passive = dict(document.get("passive", {}))
    structure = dict(document.get("structure", {}))
    for name, spring in document["flexible"].items():
        if name not in joints:
            raise InputError(
                f"{place}: flexible: no joint {name!r} that turns; "
                + suggestion(name, joints, "ones")
            )
        if name in passive:
            raise InputError(
                f"{place}: flexible.{name}: the joint is passive, and a flexible one "
                "is measured on its motor's side; leave out one"
            )
        like = {"like": flexibility(spring["like"])} if "like" in spring else {}
        passive[flexibility(name)] = {**spring, **like}
        structure[f"{name}{MOTOR}"] = {"massless": True}
        _split(root, joints[name], f"{name}{MOTOR}")
    others = {key: each for key, each in document.items() if key != "flexible"}
    return (
        {**others, "passive": passive, "structure": structure},
        ET.tostring(root, encoding="unicode") + "\n",
    )


def _split(root: ET.Element, joint: ET.Element, between: str) -> None:
    """Put a link and a joint about the same axis between a joint and its child."""
    ET.SubElement(root, "link", name=between)
    spring = ET.SubElement(
        root, "joint", name=flexibility(joint.get("name", "")), type="continuous"
    )
    ET.SubElement(spring, "parent", link=between)
    spring.extend(joint.findall("child"))
    spring.extend(joint.findall("axis"))
    for child in joint.findall("child"):
        joint.remove(child)
    ET.SubElement(joint, "child", link=between)


def make_stiff(root: ET.Element) -> None:
    """Take out of a URDF what `with_flexible_joints` has put in."""
    joints = {joint.get("name", ""): joint for joint in root.findall("joint")}
    links = {link.get("name", ""): link for link in root.findall("link")}
    for name, joint in joints.items():
        spring, motor = joints.get(flexibility(name)), links.get(f"{name}{MOTOR}")
        if spring is not None and motor is not None:
            for child in joint.findall("child"):
                joint.remove(child)
            joint.extend(spring.findall("child"))
            root.remove(spring)
            root.remove(motor)
