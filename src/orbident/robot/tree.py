"""Which link is the base, and the tree below it."""

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, replace

from orbident.errors import InputError
from orbident.files.names import listed, suggestion
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

    def rigid_group(self, link: str) -> tuple[tuple[str, ...], tuple[UrdfJoint, ...]]:
        """The links fixed to `link` from below, and the moving joints that leave them.

        The link itself is the first.
        """
        links, leaving, waiting = [], [], [link]
        while waiting:
            current = waiting.pop()
            links.append(current)
            for joint in self.children.get(current, ()):
                if joint.kind == "fixed":
                    waiting.append(joint.child)
                else:
                    leaving.append(joint)
        return tuple(links), tuple(leaving)


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
    if base_link is not None and base_link not in links:
        raise InputError(
            f"{urdf.place}: base_link: no link {base_link!r}; "
            + suggestion(base_link, links, "links")
        )
    tree = LinkTree(root, links, _children(urdf.joints), urdf.place)
    if base_link is None:
        tree = replace(tree, base=_below_world(tree))
    else:
        tree = _rerooted(tree, urdf, above, base_link)
    _refuse_unactuated(tree)
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
    group, leaving = tree.rigid_group(tree.base)
    massless = not any(tree.links[name].theta.any() for name in group)
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
            _require_only_world_above(tree, joint, base)
            del joints[joint.name]
            break
        if joint.kind != "fixed":
            raise InputError(
                f"{tree.place}: base_link '{base}' hangs below joint '{joint.name}' "
                f"({joint.kind}); give a link that is fixed to '{tree.base}'"
            )
        joints[joint.name] = _turned_round(joint)
        link = joint.parent
    return replace(tree, base=base, children=_children(joints.values()))


def _require_only_world_above(tree: LinkTree, joint: UrdfJoint, base: str) -> None:
    if _below_world(tree) != joint.child:
        raise InputError(
            f"{tree.place}: base_link '{base}' hangs below joint '{joint.name}' "
            f"({joint.kind}), but what is above has mass or other joints; only a "
            "massless root may be left out"
        )


def _turned_round(joint: UrdfJoint) -> UrdfJoint:
    # x_P = R x_C + p  <=>  x_C = R^T x_P - R^T p
    return replace(
        joint,
        parent=joint.child,
        child=joint.parent,
        R=joint.R.T,
        p=-joint.R.T @ joint.p,
    )


def _refuse_unactuated(tree: LinkTree) -> None:
    waiting = [tree.base]
    while waiting:
        for joint in tree.children.get(waiting.pop(), ()):
            if joint.kind in _UNACTUATED:
                raise InputError(
                    f"{tree.place}: joint '{joint.name}' is {joint.kind}; below the "
                    "base only revolute, continuous, prismatic and fixed joints work"
                )
            waiting.append(joint.child)
