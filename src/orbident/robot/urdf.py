"""URDF text to links and joints as plain data."""

import math
import xml.etree.ElementTree as ET
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.files.bounds import LARGEST, SMALLEST
from orbident.robot.parameters import PER_BODY, from_mass_com_inertia
from orbident.robot.urdf_xml import checked_xml


@dataclass(frozen=True)
class UrdfLink:
    """A link as the file gives it."""

    name: str
    mass: float
    com: Float[np.ndarray, "3"]
    """Position of the CM in the link's frame, m."""
    I_com: Float[np.ndarray, "3 3"]
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
    """One of `urdf_xml.KINDS`."""
    parent: str
    child: str
    R: Float[np.ndarray, "3 3"]
    """Rotates vectors from the child link's axes at q = 0 into the parent link's."""
    p: Float[np.ndarray, "3"]
    """Position of the child link's origin at q = 0 in the parent link's frame, m."""
    axis: Float[np.ndarray, "3"]
    """Unit vector, child link's axes."""
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


def read_urdf(text: str, place: str = "URDF") -> Urdf:
    """The links and joints of a URDF. No mesh is opened.

    Raises:
        InputError: see `urdf_xml.checked_xml`; also a zero axis, or limits whose
            lower end is above the upper one.
    """
    robot = checked_xml(text, place)
    warnings: list[str] = []
    links = tuple(_link(link) for link in robot.iter("link"))
    joints = tuple(_joint(joint, place, warnings) for joint in robot.iter("joint"))
    return Urdf(robot.attrib["name"], links, joints, place, tuple(warnings))


def _link(link: ET.Element) -> UrdfLink:
    name, inertial = link.attrib["name"], link.find("inertial")
    if inertial is None:
        return UrdfLink(name, 0.0, np.zeros(3), np.zeros((3, 3)))
    R, com = _placement(inertial)
    xx, xy, xz, yy, yz, zz = (
        _numbers(inertial, "inertia", f"i{axes}", (0.0,))[0]
        for axes in ("xx", "xy", "xz", "yy", "yz", "zz")
    )
    I = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    mass = _numbers(inertial, "mass", "value", (0.0,))[0]
    return UrdfLink(name, mass, com, R @ I @ R.T, R)


def _joint(joint: ET.Element, place: str, warnings: list[str]) -> UrdfJoint:
    name, kind = joint.attrib["name"], joint.attrib["type"]
    where = f"joint '{name}'"
    axis = np.array(_numbers(joint, "axis", "xyz", (1.0, 0.0, 0.0)))
    moves = kind in {"revolute", "continuous", "prismatic"}
    norm = float(np.linalg.norm(axis))
    if moves and norm < SMALLEST:
        raise InputError(f"{place}: {where}: found axis 0 0 0; give a nonzero vector")
    R, p = _placement(joint)
    return UrdfJoint(
        name,
        kind,
        _linked(joint, "parent"),
        _linked(joint, "child"),
        R,
        p,
        axis=axis / norm if moves else np.array([1.0, 0.0, 0.0]),
        position=_position_limits(joint, f"{place}: {where}", warnings),
        velocity=_velocity_limit(joint, f"{place}: {where}", warnings),
        mimic=_mimic(joint),
        gear=_first(joint, "motor", "gear"),
        armature=_first(joint, "motor", "armature") or 0.0,
    )


def _mimic(joint: ET.Element) -> Mimic | None:
    element = joint.find("mimic")
    if element is None:
        return None
    (multiplier,) = _numbers(joint, "mimic", "multiplier", (1.0,))
    (offset,) = _numbers(joint, "mimic", "offset", (0.0,))
    return Mimic(element.attrib["joint"], multiplier, offset)


def _linked(joint: ET.Element, end: str) -> str:
    return joint.findall(end)[0].attrib["link"]


def _numbers(
    element: ET.Element, tag: str, attribute: str, default: tuple[float, ...]
) -> tuple[float, ...]:
    """The numbers of a child's attribute; the default where it is absent."""
    child = element.find(tag)
    text = None if child is None else child.get(attribute)
    return default if text is None else tuple(float(word) for word in text.split())


def _placement(
    element: ET.Element,
) -> tuple[Float[np.ndarray, "3 3"], Float[np.ndarray, "3"]]:
    """`<origin>`: roll, pitch and yaw turn about the fixed axes x, y and z."""
    p = np.array(_numbers(element, "origin", "xyz", (0.0, 0.0, 0.0)))
    rpy = np.array(_numbers(element, "origin", "rpy", (0.0, 0.0, 0.0)))
    return rotation_of(rpy), p


def rotation_of(rpy: Float[np.ndarray, "3"]) -> Float[np.ndarray, "3 3"]:
    """`Rz(yaw) Ry(pitch) Rx(roll)` of roll, pitch and yaw about fixed axes, rad."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    R = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    return np.array(R)


def _first(joint: ET.Element, tag: str, attribute: str) -> float | None:
    numbers = _numbers(joint, tag, attribute, ())
    return numbers[0] if numbers else None


def _position_limits(
    joint: ET.Element, where: str, warnings: list[str]
) -> tuple[float, float] | None:
    ends = _first(joint, "limit", "lower"), _first(joint, "limit", "upper")
    if joint.attrib["type"] not in {"revolute", "prismatic"} or ends == (None, None):
        return None
    # The URDF format's default for one missing end is zero.
    lower, upper = (_unbounded(end or 0.0) for end in ends)
    if lower > upper:
        raise InputError(
            f"{where}: found lower limit {lower:g} above the upper limit {upper:g}; "
            "exchange them"
        )
    if lower == upper:
        warnings.append(
            f"joint '{joint.attrib['name']}': position limits "
            f"[{lower:g}, {upper:g}] leave no motion; taken as no limits"
        )
        return None
    return None if math.isinf(lower) and math.isinf(upper) else (lower, upper)


def _unbounded(limit: float) -> float:
    """Many files write the largest number that they can where there is no limit."""
    return math.copysign(math.inf, limit) if abs(limit) > LARGEST else limit


def _velocity_limit(joint: ET.Element, where: str, warnings: list[str]) -> float | None:
    velocity = _first(joint, "limit", "velocity")
    if velocity is None or math.isinf(_unbounded(velocity)):
        return None
    if velocity < 0:
        raise InputError(
            f"{where}: found velocity limit {velocity:g}; give more than 0"
        )
    if velocity < SMALLEST:
        warnings.append(
            f"joint '{joint.attrib['name']}': velocity limit 0 leaves no motion; "
            "taken as no limit"
        )
        return None
    return velocity
