"""URDF text to links and joints as plain data, checked."""

import math
import xml.etree.ElementTree as ET
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.files.bounds import LARGEST, SMALLEST
from orbident.files.names import first_duplicate, quoted, refuse_unknown
from orbident.robot.urdf import KINDS, Mimic, Urdf, UrdfJoint, UrdfLink, rotation_of

_ORIGIN = {"origin xyz": (0.0, 0.0, 0.0), "origin rpy": (0.0, 0.0, 0.0)}
_MOMENTS = [f"inertia i{axes}" for axes in ("xx", "xy", "xz", "yy", "yz", "zz")]
_INERTIAL = {**_ORIGIN, "mass value": (0.0,), **dict.fromkeys(_MOMENTS, (0.0,))}
_JOINT = {
    **_ORIGIN,
    "axis xyz": (1.0, 0.0, 0.0),
    "limit lower": (math.nan,),
    "limit upper": (math.nan,),
    "limit velocity": (math.inf,),
    "mimic multiplier": (1.0,),
    "mimic offset": (0.0,),
}
"""What the attribute of an element has where it is not there, and so how many numbers;
NaN where nothing is said of a limit."""

Numbers = Mapping[str, tuple[float, ...]]
Names = tuple[str, ...]


def read_urdf(text: str, place: str = "URDF") -> Urdf:
    """The links and joints of a URDF. No mesh is opened.

    Raises:
        InputError: malformed XML, no links, missing or repeated names, a parent or
            child that is no link, text where numbers belong, a mass that is
            negative or not finite, a zero axis, or limits whose lower end is above
            the upper one.
    """
    root = parsed_xml(text, place)
    if root.tag != "robot":
        raise InputError(
            f"{place}: the root element is <{root.tag}>; give <robot> (URDF, xacro), "
            "<mujoco> (MJCF) or <sdf> (SDF)"
        )
    links, joints = root.findall("link"), root.findall("joint")
    if not links:
        raise InputError(f"{place}: the robot has no <link>; give at least a base")
    name = _name(root, f"{place}: <robot>")
    link_names = unique_names(links, "link", place)
    read = tuple(
        _link(link, each, f"{place}: link '{each}'")
        for link, each in zip(links, link_names, strict=True)
    )
    joint_names = unique_names(joints, "joint", place)
    gears = _gears(root)
    given = [
        _joint(joint, each, f"{place}: joint '{each}'", link_names, joint_names, gears)
        for joint, each in zip(joints, joint_names, strict=True)
    ]
    warnings: list[str] = []
    judged = (_limited(joint, place, warnings) for joint in given)
    return Urdf(name, read, tuple(judged), place, tuple(warnings))


def _link(link: ET.Element, name: str, where: str) -> UrdfLink:
    inertials = link.findall("inertial")
    if not inertials:
        return UrdfLink(name)
    if len(inertials) > 1:
        raise InputError(f"{where}: found {len(inertials)} <inertial>; give one")
    (inertial,) = inertials
    _require(inertial, "mass", ("value",), where)
    _require(inertial, "inertia", ("ixx", "iyy", "izz"), where)
    numbers = _numbers_of(inertial, _INERTIAL, where)
    (mass,) = numbers["mass value"]
    if mass < 0:
        raise InputError(f"{where}: found mass {mass:g} kg; give zero or more")
    if mass and mass < SMALLEST:
        wanted = f"give zero, or at least {SMALLEST:g} kg"
        raise InputError(f"{where}: found mass {mass:g} kg; {wanted}")
    R, com = _placement(numbers)
    xx, xy, xz, yy, yz, zz = (numbers[key][0] for key in _MOMENTS)
    I = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return UrdfLink(name, mass, com, R @ I @ R.T, R)


def _require(
    inertial: ET.Element, tag: str, attributes: tuple[str, ...], where: str
) -> None:
    element = inertial.find(tag)
    if element is None:
        raise InputError(
            f"{where}: <inertial> has no <{tag}>; add it (zeros for a point mass), "
            "or leave out <inertial> for a massless link"
        )
    for attribute in attributes:
        if element.get(attribute) is None:
            raise InputError(f"{where}: <{tag}> has no '{attribute}'; add it")


def _joint(
    joint: ET.Element,
    name: str,
    where: str,
    links: Names,
    joints: Names,
    gears: Mapping[str, Sequence[str]],
) -> UrdfJoint:
    """A joint with its axis and its limits as they are given."""
    kind = joint.get("type")
    if kind not in KINDS:
        found = "no type" if kind is None else f"type '{kind}'"
        raise InputError(f"{where}: found {found}; give one of {', '.join(KINDS)}")
    numbers = _numbers_of(joint, _JOINT, where)
    parent, child = (_end(joint, end, where, links) for end in ("parent", "child"))
    R, p = _placement(numbers)
    gear = _of_motor(gears[name])
    return UrdfJoint(
        name,
        kind,
        parent,
        child,
        R,
        p,
        axis=np.array(numbers["axis xyz"]),
        position=(numbers["limit lower"][0], numbers["limit upper"][0]),
        velocity=numbers["limit velocity"][0],
        mimic=_mimic(joint, numbers, where, joints),
        # Nearly all files write 1 where nothing is known of a gear.
        gear=None if gear in (0.0, 1.0) else gear,
        armature=_of_motor([x.get("armature", "") for x in joint.iter("dynamics")]),
    )


def _end(joint: ET.Element, end: str, where: str, links: Names) -> str:
    found = joint.find(end)
    link = None if found is None else found.get("link")
    if link is None:
        raise InputError(f"{where}: <{end} link=...> is missing; add it")
    fault = f"{where}: the {end} link '{link}' is not in the file"
    refuse_unknown(link, links, fault, "links")
    return link


def _mimic(
    joint: ET.Element, numbers: Numbers, where: str, joints: Names
) -> Mimic | None:
    element = joint.find("mimic")
    if element is None:
        return None
    leader = element.get("joint", "")
    fault = f"{where}: <mimic>: no joint {quoted(leader)}"
    refuse_unknown(leader, joints, fault, "joints")
    return Mimic(leader, *numbers["mimic multiplier"], *numbers["mimic offset"])


def _numbers_of(element: ET.Element, usual: Numbers, where: str) -> Numbers:
    """Those of children's attributes; what is usual where one is not there."""
    numbers = dict(usual)
    for key, otherwise in usual.items():
        tag, attribute = key.split()
        child = element.find(tag)
        text = None if child is None else child.get(attribute)
        if text is not None:
            numbers[key] = numbers_in(
                text, len(otherwise), f"{where}: <{key}>", bounded=tag != "limit"
            )
    return numbers


def _placement(
    numbers: Numbers,
) -> tuple[Float[np.ndarray, "3 3"], Float[np.ndarray, "3"]]:
    """`<origin>`: roll, pitch and yaw turn about the fixed axes x, y and z."""
    return rotation_of(np.array(numbers["origin rpy"])), np.array(numbers["origin xyz"])


def _limited(joint: UrdfJoint, place: str, warnings: list[str]) -> UrdfJoint:
    """A joint with an axis of length one, and with such limits as leave it a motion."""
    where = f"{place}: joint '{joint.name}'"
    moves = joint.kind in {"revolute", "continuous", "prismatic"}
    norm = float(np.linalg.norm(joint.axis))
    if moves and norm < SMALLEST:
        raise InputError(f"{where}: found axis 0 0 0; give a nonzero vector")
    return replace(
        joint,
        axis=joint.axis / norm if moves else np.array([1.0, 0.0, 0.0]),
        position=_position_limits(joint, where, warnings),
        velocity=_velocity_limit(joint, where, warnings),
    )


def _position_limits(
    joint: UrdfJoint, where: str, warnings: list[str]
) -> tuple[float, float] | None:
    ends = joint.position or ()
    if joint.kind not in {"revolute", "prismatic"} or all(map(math.isnan, ends)):
        return None
    # The URDF format's default for one missing end, which is NaN here, is zero.
    lower, upper = (_unbounded(end) if abs(end) > 0 else 0.0 for end in ends)
    if lower > upper:
        raise InputError(
            f"{where}: found lower limit {lower:g} above the upper limit {upper:g}; "
            "exchange them"
        )
    if lower == upper:
        warnings.append(
            f"joint '{joint.name}': position limits "
            f"[{lower:g}, {upper:g}] leave no motion; taken as no limits"
        )
        return None
    return None if math.isinf(lower) and math.isinf(upper) else (lower, upper)


def _unbounded(limit: float) -> float:
    """Many files write the largest number that they can where there is no limit."""
    return math.copysign(math.inf, limit) if abs(limit) > LARGEST else limit


def _velocity_limit(joint: UrdfJoint, where: str, warnings: list[str]) -> float | None:
    velocity = joint.velocity
    if velocity is None or abs(velocity) > LARGEST:
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


def _gears(root: ET.Element) -> dict[str, list[str]]:
    """What transmissions of one joint say of its gear, by joint."""
    gears = defaultdict[str, list[str]](list)
    for transmission in root.findall("transmission"):
        names = [each.get("name", "") for each in transmission.findall("joint")]
        if len(names) == 1:
            reductions = transmission.iter("mechanicalReduction")
            gears[names[0]] += [each.text or "" for each in reductions]
    return gears


def _of_motor(texts: Sequence[str]) -> float:
    """A number of a motor; zero where there is none of a size that it may have.

    These are proposals, so that what is no number is not refused.
    """
    with suppress(ValueError):
        (number,) = map(float, texts)
        if SMALLEST <= abs(number) <= LARGEST:
            return number
    return 0.0


def parsed_xml(text: str, place: str) -> ET.Element:
    """The root element.

    Raises:
        InputError: malformed XML.
    """
    try:
        return ET.fromstring(text)
    except (ET.ParseError, ValueError) as error:
        raise InputError(f"{place}: malformed XML: {error}; repair the file") from None


def _name(element: ET.Element, where: str) -> str:
    name = element.get("name", "")
    if not name.strip():
        raise InputError(f"{where}: the attribute 'name' is missing; give one")
    return name


def unique_names(
    elements: Iterable[ET.Element], tag: str, place: str
) -> tuple[str, ...]:
    """The elements' names, in their order.

    Raises:
        InputError: an element has none, or two have the same.
    """
    names = tuple(
        _name(element, f"{place}: <{tag}> number {i}")
        for i, element in enumerate(elements, start=1)
    )
    twice = first_duplicate(names)
    if twice is not None:
        raise InputError(
            f"{place}: {tag} '{twice}' is defined twice; names must be unique"
        )
    return names


def numbers_in(
    text: str, count: int, where: str, *, bounded: bool = True
) -> tuple[float, ...]:
    """The numbers of an element or an attribute.

    There must be `count` of them. Those of a limit are not bounded: an infinite or very
    large number is a way to write that there is none.

    Raises:
        InputError: not so many, no numbers, not finite or too large.
    """
    try:
        numbers = tuple(float(word) for word in text.split())
    except ValueError:
        numbers = ()
    finite = all(math.isfinite(x) or not (bounded or math.isnan(x)) for x in numbers)
    if len(numbers) != count or not finite:
        wanted = "one finite number" if count == 1 else f"{count} finite numbers"
        hint = "; expand it with xacro first" if "${" in text else ""
        raise InputError(f"{where}: found {quoted(text)}; give {wanted}{hint}")
    if bounded and max(map(abs, numbers)) > LARGEST:
        raise InputError(
            f"{where}: found {quoted(text)}; give at most {LARGEST:g}, in SI units"
        )
    return numbers
