"""A robot as MJCF, the model file of MuJoCo: floating, without gravity."""

import xml.etree.ElementTree as ET

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from orbident.files.bounds import LARGEST
from orbident.identified.exported_robot import FEATURE_POINT, Mechanism, unused
from orbident.robot.description import Joint
from orbident.robot.parameters import FIRST_MOMENT, MASS, inertia_about_com

KINDS = {"revolute": "hinge", "prismatic": "slide"}


def mjcf(robot: Mechanism) -> str:
    """The robot as an MJCF file.

    S is a site. The base floats on a free joint, or in the plane on two slides and a
    hinge.
    """
    root = ET.Element("mujoco", model=robot.name)
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
    base = ET.SubElement(ET.SubElement(root, "worldbody"), "body", name=robot.bodies[0])
    _add_root_joints(base, robot)
    _add_inertial(base, robot.theta[0])
    ET.SubElement(base, "site", name=FEATURE_POINT, pos=_text(robot.feature_point))
    bodies = [base]
    for name, joint, theta in zip(
        robot.bodies[1:], robot.joints, robot.theta[1:], strict=True
    ):
        bodies.append(_body(bodies[joint.parent], name, joint))
        _add_inertial(bodies[-1], theta)
    for follower, leader, factor, offset in robot.couplings:
        ET.SubElement(
            ET.SubElement(root, "equality"),
            "joint",
            joint1=follower,
            joint2=leader,
            polycoef=_text([offset, factor, 0, 0, 0]),
        )
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


def _add_root_joints(base: ET.Element, robot: Mechanism) -> None:
    if robot.motion == "spatial":
        ET.SubElement(base, "freejoint")
        return
    axes = (
        ("x", "slide", "1 0 0"),
        ("y", "slide", "0 1 0"),
        ("turn", "hinge", "0 0 1"),
    )
    for name, kind, axis in axes:
        free = unused(f"{robot.bodies[0]}_{name}", [each.name for each in robot.joints])
        ET.SubElement(base, "joint", name=free, type=kind, axis=axis)


def _body(parent: ET.Element, name: str, joint: Joint) -> ET.Element:
    x = _scalar_first(Rotation.from_matrix(joint.R_PJ).as_quat())
    body = ET.SubElement(parent, "body", name=name, pos=_text(joint.p_PJ), quat=x)
    about = ET.SubElement(
        body, "joint", name=joint.name, type=KINDS[joint.kind], axis=_text(joint.axis)
    )
    if joint.position is not None:
        about.set("range", _text(joint.within(LARGEST)))
    return body


def _add_inertial(body: ET.Element, theta: Float[np.ndarray, "10"]) -> None:
    moments, axes = np.linalg.eigh(inertia_about_com(theta))
    # The largest of a thin disc is the sum of the others, but for rounding.
    moments[2] = min(moments[2], moments[0] + moments[1])
    x = Rotation.from_matrix(axes * np.linalg.det(axes)).as_quat()
    ET.SubElement(
        body,
        "inertial",
        pos=_text(theta[FIRST_MOMENT] / theta[MASS]),
        quat=_scalar_first(x),
        mass=_text([theta[MASS]]),
        diaginertia=_text(moments),
    )


def _scalar_first(x: Float[np.ndarray, "4"]) -> str:
    return _text(np.roll(x, 1))


def _text(numbers: object) -> str:
    return " ".join(repr(float(x)) for x in np.asarray(numbers))
