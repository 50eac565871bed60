"""URDF text to links and joints as plain data; the one user of yourdfpy."""

import io
import logging
import math
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

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
    """In the link's frame, m."""
    I_com: Float[np.ndarray, "3 3"]
    """About the CM, link's axes, kg m^2."""

    @property
    def theta(self) -> Float[np.ndarray, "10"]:
        """The ten parameters about the link frame's origin."""
        if not self.mass and not self.I_com.any():
            return np.zeros(PER_BODY)
        return from_mass_com_inertia(self.mass, self.com, self.I_com)


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
    """From the parent link's origin to the child's at q = 0, parent's axes, m."""
    axis: Float[np.ndarray, "3"]
    """Unit vector, child link's axes."""
    position: tuple[float, float] | None = None
    velocity: float | None = None


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

    Args:
        text: the URDF.
        place: the file's name, for messages.

    Raises:
        InputError: see `urdf_xml.checked_xml`; also a zero axis, or limits whose
            lower end is above the upper one.
    """
    xml = checked_xml(text, place)
    robot = _through_yourdfpy(xml)
    warnings: list[str] = []
    links = tuple(_link(link) for link in robot.links)
    joints = tuple(_joint(joint, place, warnings) for joint in robot.joints)
    return Urdf(robot.name, links, joints, place, tuple(warnings))


def _through_yourdfpy(xml: ET.Element) -> Any:
    # Late: the import takes most of a second, for trimesh.
    import yourdfpy

    with _silent("yourdfpy"):
        return yourdfpy.URDF.load(
            io.BytesIO(ET.tostring(xml)),
            build_scene_graph=False,
            load_meshes=False,
        ).robot


@contextmanager
def _silent(name: str) -> Iterator[None]:
    logger = logging.getLogger(name)
    level = logger.level
    logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        logger.setLevel(level)


def _link(link: Any) -> UrdfLink:
    if link.inertial is None:
        return UrdfLink(link.name, 0.0, np.zeros(3), np.zeros((3, 3)))
    R, com = _placement(link.inertial.origin)
    I_com = R @ link.inertial.inertia @ R.T
    return UrdfLink(link.name, link.inertial.mass, com, I_com)


def _joint(joint: Any, place: str, warnings: list[str]) -> UrdfJoint:
    where = f"joint '{joint.name}'"
    moves = joint.type in {"revolute", "continuous", "prismatic"}
    norm = float(np.linalg.norm(joint.axis))
    if moves and norm < SMALLEST:
        raise InputError(f"{place}: {where}: found axis 0 0 0; give a nonzero vector")
    if joint.mimic is not None:
        warnings.append(
            f"{where} mimics '{joint.mimic.joint}'; it is treated as independent "
            "and needs its own measured position"
        )
    R, p = _placement(joint.origin)
    return UrdfJoint(
        joint.name,
        joint.type,
        joint.parent,
        joint.child,
        R,
        p,
        axis=joint.axis / norm if moves else np.array([1.0, 0.0, 0.0]),
        position=_position_limits(joint, f"{place}: {where}", warnings),
        velocity=_velocity_limit(joint, f"{place}: {where}", warnings),
    )


def _placement(
    origin: Float[np.ndarray, "4 4"] | None,
) -> tuple[Float[np.ndarray, "3 3"], Float[np.ndarray, "3"]]:
    if origin is None:
        return np.eye(3), np.zeros(3)
    return origin[:3, :3], origin[:3, 3]


def _position_limits(
    joint: Any, where: str, warnings: list[str]
) -> tuple[float, float] | None:
    limit = joint.limit
    if joint.type not in {"revolute", "prismatic"} or limit is None:
        return None
    if limit.lower is None and limit.upper is None:
        return None
    # The URDF format's default for one missing end is zero.
    lower, upper = (_unbounded(end or 0.0) for end in (limit.lower, limit.upper))
    if lower > upper:
        raise InputError(
            f"{where}: found lower limit {lower:g} above the upper limit {upper:g}; "
            "exchange them"
        )
    if lower == upper:
        warnings.append(
            f"joint '{joint.name}': position limits [{lower:g}, {upper:g}] leave no "
            "motion; taken as no limits"
        )
        return None
    return None if math.isinf(lower) and math.isinf(upper) else (lower, upper)


def _unbounded(limit: float) -> float:
    """Many files write the largest number that they can where there is no limit."""
    return math.copysign(math.inf, limit) if abs(limit) > LARGEST else limit


def _velocity_limit(joint: Any, where: str, warnings: list[str]) -> float | None:
    velocity = None if joint.limit is None else joint.limit.velocity
    if velocity is None or math.isinf(_unbounded(velocity)):
        return None
    if velocity < 0:
        raise InputError(
            f"{where}: found velocity limit {velocity:g}; give more than 0"
        )
    if velocity < SMALLEST:
        warnings.append(
            f"joint '{joint.name}': velocity limit 0 leaves no motion; "
            "taken as no limit"
        )
        return None
    return velocity
