"""What a model and a robot file say of joints beside where they are."""

import json
import math
import xml.etree.ElementTree as ET
from collections.abc import Collection, Mapping, Sequence
from typing import Annotated, Any, NamedTuple

import numpy as np
from jaxtyping import Float
from pydantic import BeforeValidator

from orbident.errors import InputError
from orbident.files.names import quoted, refuse_unknown
from orbident.files.schema_parts import Name, WrongValueError, keys_of
from orbident.robot.description import (
    NO_ROTOR,
    Coupling,
    Friction,
    GearedRotor,
    Joint,
    Passive,
    Robot,
)
from orbident.robot.parameters import Structure
from orbident.robot.tolerances import EVERY
from orbident.robot.units import CONSTANT_OF_A_MOTOR, positive_of
from orbident.robot.urdf import Urdf


def couplings_of(
    urdf: Urdf, moving: Collection[str]
) -> tuple[tuple[Coupling, ...], list[str]]:
    """Couplings to joints that follow none, and a warning for each that is no coupling.

    The moving ones are the robot's joints, by name.

    Raises:
        InputError: joints follow each other in a circle.
    """
    mimics = {joint.name: joint.mimic for joint in urdf.joints}
    couplings, warnings = [], []
    for name in moving:
        leader, factor, offset = name, 1.0, 0.0
        passed = [name]
        while (mimic := mimics[leader]) is not None:
            # q = factor (multiplier q' + mimic.offset) + offset
            offset += factor * mimic.offset
            factor *= mimic.multiplier
            leader = mimic.joint
            if leader in passed:
                raise InputError(
                    f"{urdf.place}: joint '{name}' mimics itself by way of '{leader}'; "
                    "take out one <mimic>"
                )
            passed.append(leader)
        if leader == name:
            continue
        if leader in moving:
            couplings.append(Coupling(name, leader, factor, offset))
        else:
            warnings.append(
                f"joint '{name}' mimics '{leader}', which is no joint that moves here: "
                "it is taken as independent"
            )
    return tuple(couplings), warnings


class CoupledJoints(NamedTuple):
    """`q = lead q_free + offset`: all joints, of those that follow none."""

    free: list[int]
    """Which joints follow none."""
    lead: Float[np.ndarray, "joints free"]
    offset: Float[np.ndarray, " joints"]
    """rad or m."""


def coupled_joints(robot: Robot) -> CoupledJoints:
    """How joints follow those that motors move; passive ones stay at zero."""
    at = {name: k for k, name in enumerate(robot.joint_names)}
    lead, offset = np.eye(len(at)), np.zeros(len(at))
    for follower, leader, factor, shift in robot.couplings:
        lead[at[follower]] = factor * lead[at[leader]]
        offset[at[follower]] = shift
    followers = {coupling.follower for coupling in robot.couplings}
    free = [k for name, k in at.items() if name not in {*followers, *robot.passive}]
    return CoupledJoints(free, lead[:, free], offset)


def driven_alone(robot: Robot) -> list[str]:
    """Joints that nothing but their own motor moves."""
    bound = {name for each in robot.couplings for name in each[:2]}
    others = {*bound, *robot.passive}
    return [name for name in robot.joint_names if name not in others]


def _alike(given: object) -> object:
    """Joints that are like another one have its numbers."""
    if not isinstance(given, dict):
        return given
    found = dict[Any, Any](given)
    for name, entry in given.items():
        other = entry.get("like") if isinstance(entry, dict) else None
        if other is None:
            continue
        model = given.get(other)
        if set(entry) - {"like", "inertia"}:
            raise WrongValueError(
                f"{name}: like: {other} gives frequency and damping; leave out the rest"
            )
        if not isinstance(model, dict) or "like" in model or other == name:
            raise WrongValueError(
                f"{name}: like: {quoted(other)}: name another joint beside it, with a "
                "frequency of its own"
            )
        found[name] = model | entry
    return found


PassiveSection = Annotated[
    dict[Name, Annotated[Passive, keys_of(Passive)]], BeforeValidator(_alike)
]
"""As a robot file has it: springs by joint."""


def check_passive(
    passive: Collection[str], couplings: Sequence[Coupling], place: str
) -> None:
    """Refuse passive joints that do not move freely.

    Raises:
        InputError: one follows another, or another follows it.
    """
    for each in couplings:
        for name in {each.follower, each.leader} & {*passive}:
            raise InputError(
                f"{place}: passive.{name}: '{each.follower}' follows '{each.leader}' "
                "in the model, and a passive joint moves by itself; leave out one"
            )


def require_measured(robot: Robot, what: str, instead: str = "") -> None:
    """Refuse a robot with joints that nobody measures.

    What needs all joints is in words, and so is what to do instead: by default, to take
    the robot for stiff.

    Raises:
        InputError: it has such joints.
    """
    for passive in robot.passive:
        name = passive.removesuffix(BEHIND)
        how, stiff = "passive", "whose model has it fixed"
        if name != passive:
            how, stiff = "flexible", f"without '{name}' under flexible"
        raise InputError(
            f"{robot.name}: joint '{name}' is {how}, and {what} takes joints that are "
            "all driven and measured; "
            + (instead or f"use a copy of the robot file {stiff}")
        )


NONE = "none"
"""In place of a rotor, or of all: the joint's motor has no gear."""

ALONG = 1e-6
"""How far from an axis of a body a unit vector may be: files print few digits."""


RotorEntry = Annotated[
    GearedRotor,
    keys_of(GearedRotor),
    BeforeValidator(lambda given: NO_ROTOR._asdict() if given == NONE else given),
]
RotorSection = Annotated[
    dict[Name, RotorEntry],
    BeforeValidator(lambda given: {EVERY: NONE} if given == NONE else given),
]
"""As a robot file has it: rotors by joint, or `none`."""


def check_rotors(
    rotors: Mapping[str, GearedRotor],
    joints: Sequence[Joint],
    bodies: Sequence[str],
    structure: Mapping[str, Structure],
    place: str,
) -> None:
    """Refuse rotors that joints cannot have.

    Raises:
        InputError: the joint slides, or a rotor is beside a massless body, or has
            another axis than those of a body without products of inertia.
    """
    for k, joint in enumerate(joints, start=1):
        name = joint.name
        if rotors.get(name, NO_ROTOR) == NO_ROTOR:
            continue
        if joint.kind == "prismatic":
            raise InputError(
                f"{place}: rotors.{name}: the joint slides, and only rotors that turn "
                "with a joint that turns are known here; leave it out"
            )
        axes = {k: joint.axis, joint.parent: joint.R_PJ @ joint.axis}
        for body, a in axes.items():
            known = structure.get(bodies[body], Structure())
            if known.massless:
                raise InputError(
                    f"{place}: rotors.{name}: '{bodies[body]}' is massless, so that "
                    "what the rotor adds to momentum has no place; leave out one"
                )
            if known.principal_axes and np.abs(a).max() < 1 - ALONG:
                raise InputError(
                    f"{place}: rotors.{name}: its axis is none of '{bodies[body]}', so "
                    f"that momentum shows products of inertia: leave principal_axes "
                    f"out of structure.{bodies[body]}"
                )


def armature_stds(
    rotors: Mapping[str, GearedRotor], joints: Sequence[Joint]
) -> dict[str, float]:
    """Standard deviations of `N (N - 1) J` by joint, kg m^2 or kg.

    They are infinite where nothing is said of a joint's motor.
    """
    said = {joint.name: rotors.get(joint.name) for joint in joints}
    return {
        name: math.inf
        if rotor is None
        else abs(rotor.gear * (rotor.gear - 1)) * rotor.inertia * rotor.tolerance
        for name, rotor in said.items()
    }


def proposed_rotors(
    urdf: Urdf, joints: Sequence[Joint], said: Collection[str]
) -> list[str]:
    """What to say of the rotors that a model knows of, in words.

    Of the joints that are said, the robot file says it already.
    """
    turning = {j.name for j in joints if j.kind == "revolute"} - set(said)
    words = []
    for joint in urdf.joints:
        gear, armature = joint.gear, joint.armature
        if joint.name not in turning or (gear is None and not armature):
            continue
        ratio = "?" if gear is None else f"{gear:.6g}"
        inertia = f"{armature / gear**2:.4g}" if gear and armature else "?"
        if armature and gear is None:
            inertia = f"{armature:.4g} / gear^2"
        # Quoted where YAML would read something else.
        name = joint.name if joint.name.isidentifier() else json.dumps(joint.name)
        words.append(f"{name}: {{gear: {ratio}, inertia: {inertia}}}")
    if not words:
        return []
    return [
        "the model has motors with gears or armatures, of which momentum shows a part: "
        f"give rotors: {{{', '.join(words)}}} in a robot file, or rotors: none"
    ]


FrictionSection = dict[Name, Annotated[Friction, keys_of(Friction)]]
"""As a robot file has it: friction by joint."""


_CONSTANT = positive_of(
    CONSTANT_OF_A_MOTOR, "torque constant", "; negate currents of the other sign"
)
TorqueConstants = dict[Name, Annotated[float, _CONSTANT]]
"""The torque constants of a robot file, by joint, N m/A or N/A."""


def check_driven(
    sections: Mapping[str, Collection[str]], passive: Collection[str], place: str
) -> None:
    """Refuse motors and their friction at joints that nobody drives.

    The sections have the joints by the key that says something of them.

    Raises:
        InputError: one of them is passive.
    """
    for section, names in sections.items():
        for name in names:
            if name in passive:
                raise InputError(
                    f"{place}: {section}.{name}: the joint is passive: no motor drives "
                    "it, and its damping is among 'passive'; leave out one"
                )


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

    The encoder of a joint that gives way between motor and link is on its motor's side.
    Behind it stands a passive joint about the same axis, and the body between both has
    no mass: everything else knows passive joints alone. Both were read and checked.

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
    rotors = document.get("rotors", {})
    for name, spring in document["flexible"].items():
        fault = f"{place}: flexible: no joint {name!r} that turns"
        refuse_unknown(name, joints, fault, "ones")
        if name in passive:
            raise InputError(
                f"{place}: flexible.{name}: the joint is passive, and a flexible one "
                "is measured on its motor's side; leave out one"
            )
        like = {"like": flexibility(spring["like"])} if "like" in spring else {}
        passive[flexibility(name)] = {**spring, **like}
        none = rotors == NONE or rotors.get(name) == NONE
        axis = None if none else _along(joints[name])
        structure[f"{name}{MOTOR}"] = (
            {"massless": True} if axis is None else {"spins_about": axis}
        )
        _split(root, joints[name], f"{name}{MOTOR}")
    others = {key: each for key, each in document.items() if key != "flexible"}
    return (
        {**others, "passive": passive, "structure": structure},
        ET.tostring(root, encoding="unicode") + "\n",
    )


def _along(joint: ET.Element) -> str | None:
    """The axis of its frame about which a joint turns, where it is one of these."""
    axis = joint.find("axis")
    given = (axis.get("xyz", "") if axis is not None else "1 0 0").split()
    a = np.abs(np.array(given, dtype=float))
    k = int(np.argmax(a))
    return "xyz"[k] if a[k] >= (1 - ALONG) * np.linalg.norm(a) else None


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
