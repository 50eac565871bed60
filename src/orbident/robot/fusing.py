"""The tree of links below a base, and its bodies: what fixed joints hold is one.

Joints that a robot file declares to be reaction wheels are rotors of their body.
"""

from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.files.names import listed, refuse_unknown
from orbident.robot.description import Joint
from orbident.robot.parameters import (
    FIRST_MOMENT,
    MASS,
    PER_BODY,
    inertia_about_com,
    inertia_matrix,
    transformed,
)
from orbident.robot.urdf import Urdf, UrdfJoint, UrdfLink

_UNACTUATED = {"floating", "planar"}


@dataclass(frozen=True)
class LinkTree:
    """Links and joints that hang on a base link."""

    base: str
    links: dict[str, UrdfLink]
    children: dict[str, tuple[UrdfJoint, ...]]
    """Joints below each parent link, in the URDF's order."""
    place: str
    """The URDF's name, for messages."""


def link_tree(urdf: Urdf, base_link: str | None = None) -> LinkTree:
    """The tree below the base link.

    The base is the URDF's root, or the child of a floating or planar joint under a
    massless root ("world"), or `base_link`; then fixed joints above it are turned
    round.

    Raises:
        InputError: kinematic loops, several roots, an unknown `base_link` or one
            below a moving joint, floating and planar joints elsewhere.
    """
    links = {link.name: link for link in urdf.links}
    above = _joint_above_each_link(urdf)
    root = _root(urdf, above)
    if base_link is not None:
        fault = f"{urdf.place}: base_link: no link {base_link!r}"
        refuse_unknown(base_link, links, fault, "links")
    tree = LinkTree(root, links, _children(urdf.joints), urdf.place)
    if base_link is None:
        tree = replace(tree, base=_below_world(tree))
    else:
        tree = _rerooted(tree, urdf, above, base_link)
    for joint in _depth_first(tree, tree.base):
        if joint.kind in _UNACTUATED:
            raise InputError(
                f"{tree.place}: joint '{joint.name}' is {joint.kind}; below the "
                "base only revolute, continuous, prismatic and fixed joints work"
            )
    return tree


def _children(joints: Iterable[UrdfJoint]) -> dict[str, tuple[UrdfJoint, ...]]:
    children: defaultdict[str, list[UrdfJoint]] = defaultdict(list)
    for joint in joints:
        children[joint.parent].append(joint)
    return {link: tuple(below) for link, below in children.items()}


def _joint_above_each_link(urdf: Urdf) -> dict[str, UrdfJoint]:
    above: dict[str, UrdfJoint] = {}
    for joint in urdf.joints:
        other = above.setdefault(joint.child, joint)
        if other is not joint:
            raise InputError(
                f"{urdf.place}: kinematic loop: link '{joint.child}' has two parents, "
                f"through joints '{other.name}' and '{joint.name}'; remove one"
            )
    return above


def _root(urdf: Urdf, above: dict[str, UrdfJoint]) -> str:
    roots = [link.name for link in urdf.links if link.name not in above]
    if len(roots) > 1:
        raise InputError(
            f"{urdf.place}: disconnected: links {listed(roots)} have no parent "
            "(several roots); connect all but the base by joints"
        )
    for link in urdf.links:
        _refuse_cycle(link.name, above, urdf.place)
    return roots[0]


def _refuse_cycle(link: str, above: dict[str, UrdfJoint], place: str) -> None:
    passed: dict[str, str] = {}
    while link in above:
        joint = above[link]
        if joint.name in passed:
            names = list(passed)[list(passed).index(joint.name) :]
            raise InputError(
                f"{place}: kinematic loop through link '{link}' and joints "
                f"{listed(reversed(names))}; a robot must be a tree: remove one of them"
            )
        passed[joint.name] = link
        link = joint.parent


def _below_world(tree: LinkTree) -> str:
    """The link under a massless root's only, floating joint; else the root."""
    fixed, leaving = [tree.base], []
    for joint in _depth_first(tree, tree.base):
        if joint.parent in fixed and joint.kind == "fixed":
            fixed.append(joint.child)
        elif joint.parent in fixed:
            leaving.append(joint)
    massless = not any(tree.links[name].theta.any() for name in fixed)
    if massless and len(leaving) == 1 and leaving[0].kind in _UNACTUATED:
        return leaving[0].child
    return tree.base


def _rerooted(
    tree: LinkTree, urdf: Urdf, above: dict[str, UrdfJoint], base: str
) -> LinkTree:
    joints = {joint.name: joint for joint in urdf.joints}
    link = base
    while link in above:
        joint = above[link]
        if joint.kind in _UNACTUATED:
            if _below_world(tree) != joint.child:
                raise InputError(
                    f"{tree.place}: base_link '{base}' hangs below joint "
                    f"'{joint.name}' ({joint.kind}), but what is above has mass or "
                    "other joints; only a massless root may be left out"
                )
            del joints[joint.name]
            break
        if joint.kind != "fixed":
            raise InputError(
                f"{tree.place}: base_link '{base}' hangs below joint '{joint.name}' "
                f"({joint.kind}); give a link that is fixed to '{tree.base}'"
            )
        # x_P = R x_C + p  <=>  x_C = R^T x_P - R^T p
        R, p = joint.R.T, -joint.R.T @ joint.p
        joints[joint.name] = replace(joint, parent=link, child=joint.parent, R=R, p=p)
        link = joint.parent
    return replace(tree, base=base, children=_children(joints.values()))


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
    """The fused tree; the base's frame has the axes of the base link."""

    names: tuple[str, ...]
    joints: tuple[Joint, ...]
    theta: Float[np.ndarray, "bodies 10"]
    placements: dict[str, Placement]
    """Where each link is, by its name."""


def fused(
    tree: LinkTree,
    root: str | None = None,
    held: frozenset[str] = frozenset(),
    feature_point: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Bodies:
    """Fuses fixed joints, `theta_P += transformed(theta_C, R_PC, p_PC)`.

    Bodies come depth first in the URDF's order, arm by arm. A body has the name of the
    link at its joint. It begins at the root, by default the base; joints that are held
    are taken as fixed at q = 0. The first body's origin is the feature point, Eq. 27's,
    which is given in the root link's frame, m.
    """
    root = tree.base if root is None else root
    at_root = Placement(0, np.eye(3), -np.array(feature_point))
    names, placements = [root], {root: at_root}
    theta = [transformed(tree.links[root].theta, at_root.R, at_root.p)]
    joints: list[Joint] = []
    for joint in _depth_first(tree, root):
        parent = placements[joint.parent]
        R, p = parent.R @ joint.R, parent.p + parent.R @ joint.p
        theta_link = tree.links[joint.child].theta
        if joint.kind == "fixed" or joint.name in held:
            placements[joint.child] = Placement(parent.body, R, p)
            theta[parent.body] = theta[parent.body] + transformed(theta_link, R, p)
        else:
            placements[joint.child] = Placement(len(names), np.eye(3), np.zeros(3))
            kind = "prismatic" if joint.kind == "prismatic" else "revolute"
            limits = joint.position, joint.velocity
            joints.append(
                Joint(joint.name, kind, parent.body, joint.axis, R, p, *limits)
            )
            names.append(joint.child)
            theta.append(theta_link)
    stacked = np.array(theta).reshape(-1, PER_BODY)
    return Bodies(tuple(names), tuple(joints), stacked, placements)


def _depth_first(tree: LinkTree, root: str) -> Iterator[UrdfJoint]:
    waiting = list(reversed(tree.children.get(root, ())))
    while waiting:
        joint = waiting.pop()
        yield joint
        waiting.extend(reversed(tree.children.get(joint.child, ())))


BALANCE = 1e-6
"""A rotor is balanced where its errors are below this part of its own inertia."""


def wheel_on_joint(
    tree: LinkTree, joint_name: str, where: str, declared: float | None = None
) -> tuple[Float[np.ndarray, "3"], float, list[str]]:
    """The rotor on a URDF joint: its axis, base axes, its inertia, kg m^2; warnings.

    A rotor to which the URDF gives no inertia has the declared one about its axis,
    which is part of the base already, as that of a wheel without a joint.

    Raises:
        InputError: no such joint, one that cannot be a wheel, or a rotor without
            inertia about its axis, or with two.
    """
    key = f"{where}.joint"
    joints = {j.name: j for below in tree.children.values() for j in below}
    refuse_unknown(joint_name, joints, f"{key}: no joint {joint_name!r}", "joints")
    joint = joints[joint_name]
    if joint.kind not in {"revolute", "continuous"}:
        raise InputError(
            f"{key}: joint '{joint_name}' is {joint.kind}; a wheel needs a revolute "
            "or continuous joint"
        )
    on_base = fused(tree).placements.get(joint.parent)
    if on_base is None or on_base.body != 0:
        raise InputError(
            f"{key}: joint '{joint_name}' is on link '{joint.parent}', which moves; "
            "a wheel must be on the base"
        )
    alone = fused(tree, root=joint.child)
    if alone.joints:
        raise InputError(
            f"{key}: joint '{alone.joints[0].name}' moves below the wheel's joint "
            f"'{joint_name}'; a rotor must be rigid"
        )
    theta = alone.theta[0]
    inertia = float(joint.axis @ inertia_matrix(theta) @ joint.axis)
    if declared is not None:
        if inertia > 0:
            raise InputError(
                f"{where}.inertia: found {declared:g} kg m^2, but the URDF gives the "
                f"rotor on joint '{joint_name}' {inertia:g} kg m^2 about its axis; "
                "keep one"
            )
        inertia = declared
    if inertia <= 0:
        raise InputError(
            f"{key}: the rotor on joint '{joint_name}' has inertia {inertia:g} "
            "kg m^2 about its axis; give its link an <inertial>, or the wheel an "
            "'inertia' in the robot file"
        )
    axis = on_base.R @ joint.R @ joint.axis
    return axis, inertia, _imbalance(joint, theta, inertia)


def _imbalance(
    joint: UrdfJoint, theta: Float[np.ndarray, "10"], inertia: float
) -> list[str]:
    m, a = theta[MASS], joint.axis
    I_com = inertia_about_com(theta) if m else inertia_matrix(theta)
    warnings = []
    off_axis = theta[FIRST_MOMENT] - a * (a @ theta[FIRST_MOMENT])
    # Compared with the radius of gyration: m d < 1e-6 sqrt(m I).
    if np.linalg.norm(off_axis) > BALANCE * np.sqrt(m * inertia):
        distance = np.linalg.norm(off_axis) / m
        warnings.append(
            f"wheel on joint '{joint.name}': the rotor's CM is {distance:.4g} m off "
            "its axis; it is counted in the base as at q = 0"
        )
    # Axisymmetric about a: I = I_a a a^T + I_t (1 - a a^T).
    I_a = a @ I_com @ a
    I_t = (np.trace(I_com) - I_a) / 2
    symmetric = I_a * np.outer(a, a) + I_t * (np.eye(3) - np.outer(a, a))
    error = np.abs(I_com - symmetric).max()
    if error > BALANCE * inertia:
        warnings.append(
            f"wheel on joint '{joint.name}': the rotor is not axisymmetric about its "
            f"axis (off by {error:.4g} of {inertia:.4g} kg m^2); it is counted in the "
            "base as at q = 0"
        )
    return warnings
