"""The identified robot for other tools: MuJoCo, Gazebo, Basilisk, and Pinocchio.

As MJCF, as SDFormat, as a script, or as an object of the library itself; nothing else
imports these libraries. The robot floats, without gravity. In Basilisk the hub has the
base with its wheels, which are balanced: Basilisk counts them in the hub, as Eq. 5
does. An arm is a state effector: a chain of spinning bodies, or one of translating
bodies. There is none in Basilisk for other trees.
"""

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator
from importlib.metadata import version
from pprint import pformat
from string import Template
from typing import Any, SupportsFloat

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from orbident.errors import InputError
from orbident.estimation.result import Result
from orbident.extras import extra
from orbident.files.bounds import LARGEST
from orbident.identified.exported_robot import (
    FEATURE_POINT,
    NO_ARMATURE,
    Mechanism,
    add_comment,
    exported_robot,
    unused,
)
from orbident.identified.generated_code import template_text
from orbident.model.core_robot import lacking_rotors, theta_with_rotors
from orbident.robot.description import NO_FRICTION, Joint, Robot
from orbident.robot.parameters import (
    FIRST_MOMENT,
    INERTIA_ENTRIES,
    MASS,
    inertia_about_com,
    transformed,
)
from orbident.robot.urdf import roll_pitch_yaw, spaced

KINDS = {"revolute": "hinge", "prismatic": "slide"}


def mjcf(made: Mechanism) -> str:
    """The robot as an MJCF file.

    S is a site. The base floats on a free joint, or in the plane on two slides and a
    hinge.
    """
    robot = made.robot
    root = ET.Element("mujoco", model=robot.name)
    add_comment(root, lacking_rotors(robot))
    # Neither may MuJoCo repair an inertia nor weigh a shape.
    ET.SubElement(
        root,
        "compiler",
        angle="radian",
        autolimits="true",
        balanceinertia="false",
        inertiafromgeom="false",
    )
    ET.SubElement(root, "option", gravity="0 0 0")
    base = ET.SubElement(ET.SubElement(root, "worldbody"), "body", name=made.bodies[0])
    _add_root_joints(base, made)
    _add_inertial(base, made.theta[0])
    ET.SubElement(base, "site", name=FEATURE_POINT, pos=spaced(robot.feature_point))
    bodies = [base]
    for k, joint in enumerate(made.joints):
        bodies.append(_body(bodies[joint.parent], made, k))
    for follower, leader, factor, offset in robot.couplings:
        ET.SubElement(
            ET.SubElement(root, "equality"),
            "joint",
            joint1=follower,
            joint2=leader,
            polycoef=spaced([offset, factor, 0, 0, 0]),
        )
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


def _add_root_joints(base: ET.Element, made: Mechanism) -> None:
    if made.robot.motion == "spatial":
        ET.SubElement(base, "freejoint")
        return
    axes = (
        ("x", "slide", "1 0 0"),
        ("y", "slide", "0 1 0"),
        ("turn", "hinge", "0 0 1"),
    )
    for name, kind, axis in axes:
        free = unused(f"{made.bodies[0]}_{name}", [each.name for each in made.joints])
        ET.SubElement(base, "joint", name=free, type=kind, axis=axis)


def _body(parent: ET.Element, made: Mechanism, k: int) -> ET.Element:
    """The body that joint `k` moves."""
    name, joint = made.bodies[k + 1], made.joints[k]
    friction = made.robot.friction.get(joint.name, NO_FRICTION)
    x = _quaternion(joint.R_PJ)
    body = ET.SubElement(parent, "body", name=name, pos=spaced(joint.p_PJ), quat=x)
    about = ET.SubElement(
        body, "joint", name=joint.name, type=KINDS[joint.kind], axis=spaced(joint.axis)
    )
    if joint.position is not None:
        about.set("range", spaced(joint.within(LARGEST)))
    for key, value in (
        ("armature", float(made.armature[k])),
        ("damping", friction.viscous),
        ("frictionloss", friction.coulomb),
    ):
        if value:
            about.set(key, repr(value))
    _add_inertial(body, made.theta[k + 1])
    return body


def _add_inertial(body: ET.Element, theta: Float[np.ndarray, "10"]) -> None:
    moments, axes = np.linalg.eigh(inertia_about_com(theta))
    # The largest of a thin disc is the sum of the others, but for rounding.
    moments[2] = min(moments[2], moments[0] + moments[1])
    ET.SubElement(
        body,
        "inertial",
        pos=spaced(theta[FIRST_MOMENT] / theta[MASS]),
        quat=_quaternion(axes * np.linalg.det(axes)),
        mass=spaced([theta[MASS]]),
        diaginertia=spaced(moments),
    )


def _quaternion(R: Float[np.ndarray, "3 3"]) -> str:
    return spaced(Rotation.from_matrix(R).as_quat(scalar_first=True))


VERSION = "1.7"
"""The first in which frames, such as that of S, mean what they do today."""


def sdf(made: Mechanism) -> str:
    """The robot as an SDF file with one model.

    Links stand where they are at `q = 0`; the model's frame is the base link's. S is a
    frame. The base is free, in the plane too: no joint of the format holds it there.
    """
    root = ET.Element("sdf", version=VERSION)
    add_comment(root, lacking_rotors(made.robot, NO_ARMATURE))
    model = ET.SubElement(root, "model", name=made.robot.name)
    R, p = [np.eye(3)], [np.zeros(3)]
    for joint in made.joints:
        R_0, p_0 = R[joint.parent], p[joint.parent]
        R.append(R_0 @ joint.R_PJ)
        p.append(p_0 + R_0 @ joint.p_PJ)
    for k, name in enumerate(made.bodies):
        link = ET.SubElement(model, "link", name=name)
        _add(link, "pose", [*p[k], *roll_pitch_yaw(R[k])])
        ET.SubElement(link, "gravity").text = "false"
        theta, inertial = made.theta[k], ET.SubElement(link, "inertial")
        _add(inertial, "pose", [*(theta[FIRST_MOMENT] / theta[MASS]), 0, 0, 0])
        _add(inertial, "mass", [theta[MASS]])
        inertia, I = ET.SubElement(inertial, "inertia"), inertia_about_com(theta)
        for a, b in INERTIA_ENTRIES:
            _add(inertia, f"i{'xyz'[a]}{'xyz'[b]}", [I[a, b]])
    # Links, joints and frames share their names.
    taken = [*made.bodies]
    for joint, child in zip(made.joints, made.bodies[1:], strict=True):
        taken.append(unused(joint.name, taken))
        _add_joint(model, taken[-1], joint, made.bodies[joint.parent], child)
    name = unused(FEATURE_POINT, taken)
    S = ET.SubElement(model, "frame", name=name, attached_to=made.bodies[0])
    _add(S, "pose", [*made.robot.feature_point, 0, 0, 0])
    ET.indent(root)
    return ET.tostring(root, encoding="unicode", xml_declaration=True) + "\n"


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


def _add(parent: ET.Element, tag: str, numbers: Iterable[SupportsFloat]) -> None:
    ET.SubElement(parent, tag).text = spaced(numbers)


ELSEWHERE = "export a .xml, which Basilisk's MuJoCo scenes read"


def basilisk_script(made: Mechanism) -> str:
    """The text of the script.

    Raises:
        InputError: an arm branches, or has joints that turn and joints that slide.
    """
    robot = made.robot
    hub = transformed(theta_with_rotors(robot)[0], np.eye(3), robot.feature_point)
    wheels = [
        {"name": w.name, "axis": w.axis.tolist(), "inertia": float(w.inertia)}
        for w in robot.wheels
    ]
    arms = [
        [_link(made, k) for k in _arm(robot, first)]
        for first, joint in enumerate(robot.joints)
        if joint.parent == 0
    ]
    data = {
        "NAME": robot.name,
        "HUB": _mass(hub),
        "ARMS": arms,
        "WHEELS": wheels,
        "FEATURE_POINT": robot.feature_point.tolist(),
    }
    lines = [f"{key} = {pformat(x, sort_dicts=False)}" for key, x in data.items()]
    if lacks := lacking_rotors(robot, NO_ARMATURE):
        lines.insert(0, f"# {lacks}.")
    # A name may hold quotes.
    name = "".join(c for c in robot.name if c.isalnum() or c in " -_.")
    head = Template(template_text("basilisk_head.txt"))
    about = head.substitute(name=name, version=version("orbident"))
    return "\n".join([about, *lines, template_text("basilisk.txt")])


def _arm(robot: Robot, first: int) -> Iterator[int]:
    """The joints of an arm, from the hub on.

    Raises:
        InputError: as `basilisk_script`.
    """
    at = first
    while True:
        if robot.joints[at].kind != robot.joints[first].kind:
            raise InputError(
                f"{robot.name}: joint '{robot.joints[at].name}' slides where others of "
                "its arm turn, or the other way round, which Basilisk's arms cannot; "
                f"{ELSEWHERE}"
            )
        yield at
        beyond = [k for k, each in enumerate(robot.joints) if each.parent == at + 1]
        if len(beyond) > 1:
            raise InputError(
                f"{robot.name}: two joints are on body '{robot.bodies[at + 1]}', but "
                f"Basilisk's arms have no branches; {ELSEWHERE}"
            )
        if not beyond:
            return
        at = beyond[0]


def _link(made: Mechanism, k: int) -> dict[str, Any]:
    joint = made.joints[k]
    return {
        "joint": joint.name,
        "kind": joint.kind,
        "position": joint.p_PJ.tolist(),
        "rotation": joint.R_PJ.tolist(),
        "axis": joint.axis.tolist(),
        **_mass(made.theta[k + 1]),
    }


def _mass(theta: Float[np.ndarray, "10"]) -> dict[str, Any]:
    return {
        "mass": float(theta[MASS]),
        "com": (theta[FIRST_MOMENT] / theta[MASS]).tolist(),
        "inertia": inertia_about_com(theta).tolist(),
    }


def mujoco_spec(result: Result) -> Any:
    """The robot as a `mujoco.MjSpec`, as its MJCF file says it.

    Raises:
        InputError: as `exported_robot`, or mujoco is not installed.
    """
    with extra("mujoco", "to_mujoco()"):
        import mujoco

    text = mjcf(exported_robot(result))
    return mujoco.MjSpec.from_string(text)  # pyright: ignore[reportAttributeAccessIssue]: compiled


def pinocchio_model(result: Result) -> Any:
    """The robot as a `pinocchio.Model` without gravity.

    Its joint `root_joint` is a free flyer, or in the plane a planar joint; bodies and
    S are frames.

    Raises:
        InputError: as `exported_robot`, or pinocchio is not installed.
    """
    with extra("pinocchio", "to_pinocchio()"):
        import pinocchio
    made = exported_robot(result)
    # Compiled, without stubs.
    pin: Any = pinocchio
    model = pin.Model()
    model.name = made.robot.name
    model.gravity.linear = np.zeros(3)
    free = pin.JointModelFreeFlyer()
    root = pin.JointModelPlanar() if made.robot.motion == "planar" else free
    moving = [model.addJoint(0, root, pin.SE3.Identity(), "root_joint")]
    for joint in made.joints:
        kind = (
            pin.JointModelRevoluteUnaligned
            if joint.kind == "revolute"
            else pin.JointModelPrismaticUnaligned
        )
        at = pin.SE3(joint.R_PJ, joint.p_PJ)
        low, high = joint.position or (-np.inf, np.inf)
        speed = np.inf if joint.velocity is None else joint.velocity
        ends = (np.array([x]) for x in (np.inf, speed, low, high))
        parent = moving[joint.parent]
        moving.append(model.addJoint(parent, kind(joint.axis), at, joint.name, *ends))
    model.armature[model.nv - len(made.joints) :] = made.armature
    for index, name, theta in zip(moving, made.bodies, made.theta, strict=True):
        inertia = pin.Inertia.FromDynamicParameters(theta)
        model.appendBodyToJoint(index, inertia, pin.SE3.Identity())
        carrier = model.addJointFrame(index)
        model.addBodyFrame(name, index, pin.SE3.Identity(), carrier)
    S = pin.SE3(np.eye(3), made.robot.feature_point)
    base = model.getFrameId(made.bodies[0])
    model.addFrame(pin.Frame(FEATURE_POINT, moving[0], base, S, pin.FrameType.OP_FRAME))
    return model
