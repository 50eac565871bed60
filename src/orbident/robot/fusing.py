"""A tree of links to a tree of bodies: what fixed joints hold is one body."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from orbident.robot.description import Joint
from orbident.robot.parameters import PER_BODY, transformed
from orbident.robot.tree import LinkTree
from orbident.robot.urdf import UrdfJoint


@dataclass(frozen=True)
class Placement:
    """Where a link sits in its body at q = 0."""

    body: int
    R: Float[np.ndarray, "3 3"]
    """Rotates vectors from the link's axes into the body's."""
    p: Float[np.ndarray, "3"]
    """Vector from the body's origin to the link's, body axes, m."""


@dataclass(frozen=True)
class Bodies:
    """The fused tree; the base's frame is the base link's."""

    names: tuple[str, ...]
    joints: tuple[Joint, ...]
    theta: Float[np.ndarray, "bodies 10"]
    placements: dict[str, Placement]
    """Where each link is, by its name."""


def fused(
    tree: LinkTree, root: str | None = None, held: frozenset[str] = frozenset()
) -> Bodies:
    """Fuses fixed joints, `theta_P += transformed(theta_C, R_PC, p_PC)`.

    Bodies come depth first in the URDF's order, arm by arm. A body has the name of
    the link at its joint.

    Args:
        tree: links and joints.
        root: the link to start at; the base where absent.
        held: joints to be taken as fixed at q = 0.
    """
    root = tree.base if root is None else root
    names, theta = [root], [tree.links[root].theta]
    joints: list[Joint] = []
    placements = {root: Placement(0, np.eye(3), np.zeros(3))}
    for joint in _depth_first(tree, root):
        parent = placements[joint.parent]
        R, p = parent.R @ joint.R, parent.p + parent.R @ joint.p
        theta_link = tree.links[joint.child].theta
        if joint.kind == "fixed" or joint.name in held:
            placements[joint.child] = Placement(parent.body, R, p)
            theta[parent.body] = theta[parent.body] + transformed(theta_link, R, p)
        else:
            placements[joint.child] = Placement(len(names), np.eye(3), np.zeros(3))
            joints.append(_joint(joint, parent.body, R, p))
            names.append(joint.child)
            theta.append(theta_link)
    return Bodies(
        tuple(names),
        tuple(joints),
        np.array(theta).reshape(-1, PER_BODY),
        placements,
    )


def about_feature_point(bodies: Bodies, p_LS: Float[np.ndarray, "3"]) -> Bodies:
    """Moves the base body's origin from the base link's frame L to S, Eq. 27's point.

    Args:
        bodies: the base's frame is the base link's.
        p_LS: S in the base link's frame, m.
    """
    theta = bodies.theta.copy()
    theta[0] = transformed(theta[0], np.eye(3), -p_LS)
    joints = tuple(
        replace(joint, p_PJ=joint.p_PJ - p_LS) if joint.parent == 0 else joint
        for joint in bodies.joints
    )
    placements = {
        link: replace(at, p=at.p - p_LS) if at.body == 0 else at
        for link, at in bodies.placements.items()
    }
    return Bodies(bodies.names, joints, theta, placements)


def _depth_first(tree: LinkTree, root: str) -> Iterator[UrdfJoint]:
    waiting = list(reversed(tree.children.get(root, ())))
    while waiting:
        joint = waiting.pop()
        yield joint
        waiting.extend(reversed(tree.children.get(joint.child, ())))


def _joint(
    joint: UrdfJoint,
    parent: int,
    R: Float[np.ndarray, "3 3"],
    p: Float[np.ndarray, "3"],
) -> Joint:
    return Joint(
        name=joint.name,
        kind="prismatic" if joint.kind == "prismatic" else "revolute",
        parent=parent,
        axis=joint.axis,
        R_PJ=R,
        p_PJ=p,
        position=joint.position,
        velocity=joint.velocity,
    )
