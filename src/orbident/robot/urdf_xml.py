"""The URDF's XML, checked; what the reader of URDF would trip over is refused here."""

import math
import xml.etree.ElementTree as ET
from collections.abc import Iterable

from orbident.errors import InputError
from orbident.files.bounds import LARGEST, SMALLEST
from orbident.files.names import first_duplicate, quoted, suggestion

KINDS = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")

_INERTIAL = {
    "origin": {"xyz": 3, "rpy": 3},
    "mass": {"value": 1},
    "inertia": dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), 1),
}
_JOINT = {
    "origin": {"xyz": 3, "rpy": 3},
    "axis": {"xyz": 3},
    "limit": {"lower": 1, "upper": 1, "velocity": 1},
    "mimic": {"multiplier": 1, "offset": 1},
}
"""How many numbers an element's attribute has."""


def checked_xml(text: str, place: str) -> ET.Element:
    """A `<robot>` with only what inertial parameters depend on.

    Links keep `<inertial>`, joints keep parent, child, origin, axis, limit and
    mimic, and get a `<motor>` of what is said of theirs. Visuals and collisions go, so
    that no mesh is ever looked for.

    Raises:
        InputError: malformed XML, no links, missing or repeated names, a parent or
            child that is no link, text where numbers belong, a mass that is
            negative or not finite.
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
    clean = ET.Element("robot", name=_name(root, f"{place}: <robot>"))
    names = unique_names(links, "link", place)
    for link, name in zip(links, names, strict=True):
        clean.append(_clean_link(link, name, f"{place}: link '{name}'"))
    joint_names = unique_names(joints, "joint", place)
    for joint, name in zip(joints, joint_names, strict=True):
        where = f"{place}: joint '{name}'"
        clean.append(_clean_joint(joint, name, names, where))
        for mimic in clean[-1].iter("mimic"):
            leader = joint.findall("mimic")[0].get("joint", "")
            if leader not in joint_names:
                raise InputError(
                    f"{where}: <mimic>: no joint {quoted(leader)}; "
                    + suggestion(leader, joint_names, "joints")
                )
            mimic.set("joint", leader)
        clean[-1].append(_motor(joint, name, root.findall("transmission")))
    return clean


def _motor(
    joint: ET.Element, name: str, transmissions: Iterable[ET.Element]
) -> ET.Element:
    """The gear and the armature of a joint's motor, where the file has them.

    They are proposals, so that what is no number is not refused.
    """
    said = {"armature": [each.get("armature", "") for each in joint.iter("dynamics")]}
    said["gear"] = [
        reduction.text or ""
        for transmission in transmissions
        if [each.get("name") for each in transmission.findall("joint")] == [name]
        for reduction in transmission.iter("mechanicalReduction")
    ]
    motor = ET.Element("motor")
    for key, texts in said.items():
        if len(texts) == 1 and (number := _number(texts[0])):
            motor.set(key, repr(number))
    # Nearly all files write 1 where nothing is known of a gear.
    if float(motor.get("gear", 1.0)) == 1.0:
        motor.attrib.pop("gear", None)
    return motor


def _number(text: str) -> float:
    """A number of a size that a motor may have; zero where it is none."""
    try:
        number = float(text)
    except ValueError:
        return 0.0
    return number if SMALLEST <= abs(number) <= LARGEST else 0.0


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


def _clean_link(link: ET.Element, name: str, where: str) -> ET.Element:
    clean = ET.Element("link", name=name)
    inertials = link.findall("inertial")
    if len(inertials) > 1:
        raise InputError(f"{where}: found {len(inertials)} <inertial>; give one")
    for inertial in inertials:
        _require(inertial, "mass", ("value",), where)
        _require(inertial, "inertia", ("ixx", "iyy", "izz"), where)
        kept = _numeric_children(inertial, _INERTIAL, where)
        mass = float(next(kept.iter("mass")).attrib["value"])
        if mass < 0:
            raise InputError(f"{where}: found mass {mass:g} kg; give zero or more")
        if mass and mass < SMALLEST:
            wanted = f"give zero, or at least {SMALLEST:g} kg"
            raise InputError(f"{where}: found mass {mass:g} kg; {wanted}")
        clean.append(kept)
    return clean


def _clean_joint(
    joint: ET.Element, name: str, links: tuple[str, ...], where: str
) -> ET.Element:
    kind = joint.get("type")
    if kind not in KINDS:
        found = "no type" if kind is None else f"type '{kind}'"
        raise InputError(f"{where}: found {found}; give one of {', '.join(KINDS)}")
    clean = _numeric_children(joint, _JOINT, where)
    clean.set("name", name)
    clean.set("type", kind)
    for end in ("parent", "child"):
        found = joint.find(end)
        link = None if found is None else found.get("link")
        if link is None:
            raise InputError(f"{where}: <{end} link=...> is missing; add it")
        if link not in links:
            raise InputError(
                f"{where}: the {end} link '{link}' is not in the file; "
                + suggestion(link, links, "links")
            )
        ET.SubElement(clean, end, link=link)
    return clean


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


def _numeric_children(
    element: ET.Element, table: dict[str, dict[str, int]], where: str
) -> ET.Element:
    """A copy of the element with only the children and attributes in the table."""
    clean = ET.Element(element.tag)
    for tag, attributes in table.items():
        child = element.find(tag)
        if child is None:
            continue
        kept = ET.SubElement(clean, tag)
        for attribute, count in attributes.items():
            text = child.get(attribute)
            if text is not None:
                numbers_in(
                    text,
                    count,
                    f"{where}: <{tag} {attribute}>",
                    bounded=tag != "limit",
                )
                kept.set(attribute, text)
    return clean


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
