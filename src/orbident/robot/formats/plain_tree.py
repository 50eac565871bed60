"""Bodies and DH tables of a robot file to links and joints.

A row of a DH table with `a`, `alpha`, `d`, `theta` puts frame `i` where

    standard:  T = Rz(theta) Tz(d) Tx(a) Rx(alpha),  joint `i` about z of frame i - 1,
    modified:  T = Rx(alpha) Tx(a) Rz(theta) Tz(d),  joint `i` about z of frame i,

after frame `i - 1`; the joint's angle is added to `theta`, its way to `d`.
"""

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float

from orbident.robot.body_schema import BodyEntry, DhRow, DhTable, MassEntry
from orbident.robot.urdf import Urdf, UrdfJoint, UrdfLink, rotation_of

NO_AXIS = np.array([1.0, 0.0, 0.0])
"""Of a joint that does not move."""


def tree_of_bodies(bodies: Mapping[str, BodyEntry], name: str, place: str) -> Urdf:
    """The links and joints of `bodies:`.

    Args:
        bodies: by name; each stands in the frame of its joint.
        name: of the robot.
        place: the robot file's name, for messages.
    """
    links = tuple(_link(body, entry, np.zeros(3)) for body, entry in bodies.items())
    joints = tuple(
        UrdfJoint(
            entry.joint or f"{body}_fixed",
            entry.type,
            entry.parent,
            body,
            rotation_of(np.array(entry.rpy)),
            np.array(entry.xyz),
            NO_AXIS if entry.axis is None else np.array(entry.axis),
        )
        for body, entry in bodies.items()
        if entry.parent is not None
    )
    return Urdf(name, links, joints, place)


def tree_of_table(table: DhTable, name: str, place: str) -> Urdf:
    """The links and joints of `dh:`.

    A link's frame has the axes of its DH frame, and stands at its joint. With the
    standard convention that is beside the DH frame, at the origin of the one before.

    Args:
        table: base and rows; mass, CM and inertia of a link in its DH frame.
        name: of the robot.
        place: the robot file's name, for messages.
    """
    parent, base = table.base.name, table.base
    links, joints = [_link(parent, base, np.zeros(3))], []
    # Frame i - 1 in the parent's link frame.
    R, p = rotation_of(np.array(base.rpy)), np.array(base.xyz)
    for k, row in enumerate(table.rows, start=1):
        if table.convention == "modified":
            R_row, to_joint, behind, axis = _modified(row)
        else:
            R_row, to_joint, behind, axis = _standard(row)
        link = row.link or f"link{k}"
        links.append(_link(link, row, behind))
        joints.append(
            UrdfJoint(
                row.joint, row.type, parent, link, R @ R_row, p + R @ to_joint, axis
            )
        )
        parent, R, p = link, np.eye(3), behind
    return Urdf(name, tuple(links), tuple(joints), place)


def _link(name: str, entry: MassEntry, origin: Float[np.ndarray, "3"]) -> UrdfLink:
    """The link whose mass is given in a frame that stands at `origin` in its own."""
    com = origin + entry.com if entry.mass else np.zeros(3)
    return UrdfLink(name, entry.mass, com, entry.I_com)


def _standard(row: DhRow) -> tuple[Float[np.ndarray, "..."], ...]:
    """Axes of frame i in those of i - 1; joint; DH frame i from there; axis in i."""
    R = rotation_of(np.array([0.0, 0.0, row.theta])) @ _about_x(row.alpha)
    c, s = np.cos(row.alpha), np.sin(row.alpha)
    behind = np.array([row.a, row.d * s, row.d * c])
    return R, np.zeros(3), behind, np.array([0.0, s, c])


def _modified(row: DhRow) -> tuple[Float[np.ndarray, "..."], ...]:
    """The same where the joint is at frame i itself."""
    turned = _about_x(row.alpha)
    R = turned @ rotation_of(np.array([0.0, 0.0, row.theta]))
    z = np.array([0.0, 0.0, 1.0])
    to_joint = np.array([row.a, 0.0, 0.0]) + turned @ (row.d * z)
    return R, to_joint, np.zeros(3), z


def _about_x(angle: float) -> Float[np.ndarray, "3 3"]:
    return rotation_of(np.array([angle, 0.0, 0.0]))
