"""Links and joints as plain data, and as the text of a URDF that says the same."""

import math
import xml.etree.ElementTree as ET
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import NamedTuple, SupportsFloat

import numpy as np
from jaxtyping import Float

from orbident.files.bounds import LARGEST
from orbident.robot.parameters import PER_BODY, from_mass_com_inertia

KINDS = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")

UNLIMITED = 10 * LARGEST
"""Other readers of a URDF want a number where there is no limit; ours takes one that
is larger than `LARGEST` for none."""


@dataclass(frozen=True)
class UrdfLink:
    """A link as the file gives it; without mass by default."""

    name: str
    mass: float = 0.0
    com: Float[np.ndarray, "3"] = field(default_factory=lambda: np.zeros(3))
    """Position of the CM in the link's frame, m."""
    I_com: Float[np.ndarray, "3 3"] = field(default_factory=lambda: np.zeros((3, 3)))
    """About the CM, link's axes, kg m^2."""
    R: Float[np.ndarray, "3 3"] = field(default_factory=lambda: np.eye(3))
    """Rotates vectors from the axes of the file's inertia into the link's."""

    @property
    def I_file(self) -> Float[np.ndarray, "3 3"]:
        """The inertia as the file gives it, kg m^2."""
        return self.R.T @ self.I_com @ self.R

    @property
    def theta(self) -> Float[np.ndarray, "10"]:
        """The ten parameters about the link frame's origin."""
        if not self.mass and not self.I_com.any():
            return np.zeros(PER_BODY)
        return from_mass_com_inertia(self.mass, self.com, self.I_com)


class Mimic(NamedTuple):
    """`q = multiplier q' + offset`, where `q'` is another joint's."""

    joint: str
    multiplier: float
    offset: float
    """rad or m."""


@dataclass(frozen=True)
class UrdfJoint:
    """A joint as the file gives it; fixed, floating and planar ones included."""

    name: str
    kind: str
    """The type of the joint: one of those in `KINDS`."""
    parent: str
    child: str
    R: Float[np.ndarray, "3 3"]
    """Rotates vectors from the child link's axes at q = 0 into the parent link's."""
    p: Float[np.ndarray, "3"]
    """Position of the child link's origin at q = 0 in the parent link's frame, m."""
    axis: Float[np.ndarray, "3"] = field(default_factory=lambda: np.eye(3)[0])
    """Unit vector, child link's axes; any one of a joint that does not move."""
    position: tuple[float, float] | None = None
    velocity: float | None = None
    mimic: Mimic | None = None
    gear: float | None = None
    """How many times as fast as it its motor turns; None where that is not said."""
    armature: float = 0.0
    """What its motor's rotor adds to its inertia, kg m^2."""


@dataclass(frozen=True)
class Urdf:
    """A URDF's links and joints, in the file's order."""

    name: str
    links: tuple[UrdfLink, ...]
    joints: tuple[UrdfJoint, ...]
    place: str
    """The file's name, for messages."""
    warnings: tuple[str, ...] = ()


def urdf_text(tree: Urdf) -> str:
    """The URDF that has these links and joints; `read_urdf` gives them back."""
    root = ET.Element("robot", name=tree.name)
    for link in tree.links:
        element = ET.SubElement(root, "link", name=link.name)
        if link.mass or link.I_com.any():
            element.append(inertial_element(link.mass, link.com, link.I_com))
    for joint in tree.joints:
        root.append(_joint(joint))
        if joint.gear is not None:
            root.append(_transmission(joint.name, joint.gear))
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


def inertial_element(
    mass: float, com: Float[np.ndarray, "3"], I_com: Float[np.ndarray, "3 3"]
) -> ET.Element:
    """A link's mass, CM and inertia about the CM, in the link's axes; SI."""
    element = ET.Element("inertial")
    ET.SubElement(element, "origin", xyz=spaced(com))
    ET.SubElement(element, "mass", value=repr(float(mass)))
    entries = {
        f"i{'xyz'[a]}{'xyz'[b]}": repr(float(I_com[a, b]))
        for a in range(3)
        for b in range(a, 3)
    }
    ET.SubElement(element, "inertia", entries)
    return element


def _joint(joint: UrdfJoint) -> ET.Element:
    free = joint.kind == "revolute" and joint.position is None
    kind = "continuous" if free else joint.kind
    element = ET.Element("joint", name=joint.name, type=kind)
    ET.SubElement(element, "parent", link=joint.parent)
    ET.SubElement(element, "child", link=joint.child)
    ET.SubElement(
        element, "origin", xyz=spaced(joint.p), rpy=spaced(roll_pitch_yaw(joint.R))
    )
    if joint.kind == "fixed":
        return element
    ET.SubElement(element, "axis", xyz=spaced(joint.axis))
    lower, upper = joint.position or (-UNLIMITED, UNLIMITED)
    limit = {"effort": UNLIMITED, "velocity": joint.velocity or UNLIMITED}
    if not free:
        limit |= {"lower": lower, "upper": upper}
    ET.SubElement(element, "limit", {name: repr(float(x)) for name, x in limit.items()})
    if joint.armature:
        ET.SubElement(element, "dynamics", armature=repr(joint.armature))
    if joint.mimic is not None:
        leader, *line = joint.mimic
        line = dict(zip(("multiplier", "offset"), map(repr, line), strict=True))
        ET.SubElement(element, "mimic", {"joint": leader} | line)
    return element


def _transmission(joint: str, gear: float) -> ET.Element:
    element = ET.Element("transmission", name=f"{joint}_transmission")
    ET.SubElement(element, "type").text = "transmission_interface/SimpleTransmission"
    ET.SubElement(element, "joint", name=joint)
    actuator = ET.SubElement(element, "actuator", name=f"{joint}_motor")
    ET.SubElement(actuator, "mechanicalReduction").text = repr(gear)
    return element


def spaced(numbers: Iterable[SupportsFloat]) -> str:
    """Numbers as an attribute holds several, to the last bit."""
    return " ".join(repr(float(x)) for x in numbers)


def rotation_of(rpy: Float[np.ndarray, "3"]) -> Float[np.ndarray, "3 3"]:
    """`Rz(yaw) Ry(pitch) Rx(roll)` of roll, pitch and yaw about fixed axes, rad."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    R = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    return np.array(R)


def roll_pitch_yaw(R: Float[np.ndarray, "3 3"]) -> Float[np.ndarray, "3"]:
    """The angles of `R = Rz(yaw) Ry(pitch) Rx(roll)`, rad.

    Pitch and roll are those of `Rz(-yaw) R`, so that the three give `R` back to
    rounding where the pitch is near 90 degrees and the yaw alone means nothing, too.
    """
    yaw = math.atan2(R[1, 0], R[0, 0])
    c, s = math.cos(yaw), math.sin(yaw)
    P = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) @ R
    return np.array([math.atan2(-P[1, 2], P[1, 1]), math.atan2(-P[2, 0], P[0, 0]), yaw])
