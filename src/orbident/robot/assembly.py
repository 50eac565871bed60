"""A robot from its checked file and its URDF."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.files.names import suggestion
from orbident.orbits.orbit import Orbit
from orbident.robot.couplings import couplings_of
from orbident.robot.description import (
    Joint,
    Robot,
    Wheel,
)
from orbident.robot.fusing import Bodies, about_feature_point, fused, rotor
from orbident.robot.physical_inertia import contradictions, nonphysical
from orbident.robot.schema import (
    LimitEntry,
    RobotFile,
    WheelEntry,
)
from orbident.robot.tree import LinkTree, link_tree
from orbident.robot.urdf import Urdf


def assembled(
    file: RobotFile,
    document: dict[str, Any],
    urdf: Urdf,
    text: str,
    place: str,
    orbit: Orbit | None = None,
) -> Robot:
    """The robot that a robot file and its URDF describe.

    Args:
        file: the checked robot file.
        document: the same, as read.
        urdf: the URDF's links and joints.
        text: the URDF's text.
        place: the robot file's name, for messages.
        orbit: the orbit that the file gives.

    Raises:
        InputError: the file names joints or bodies that the URDF does not have, a
            joint that cannot be a wheel, or nothing has mass.
    """
    tree = link_tree(urdf, file.base_link)
    wheels, wheel_warnings = _wheels(file, tree, place)
    feature_point = np.array(file.feature_point)
    held = frozenset(w.joint for w in file.wheels if w.joint is not None)
    bodies = about_feature_point(fused(tree, held=held), feature_point)
    _require_mass(bodies, urdf.place)
    _require_bodies("structure", file.structure, bodies, place)
    couplings, uncoupled = couplings_of(urdf, [joint.name for joint in bodies.joints])
    _require_bodies("pads", file.pads, bodies, place)
    return Robot(
        name=file.name or urdf.name,
        motion=file.motion,
        bodies=bodies.names,
        joints=_limited(bodies.joints, file.limits, place),
        theta=bodies.theta,
        feature_point=feature_point,
        couplings=couplings,
        wheels=wheels,
        thrusters=file.thrusters,
        torquers=file.torquers,
        pads=_pads(file, bodies),
        disturbances=file.disturbances,
        momentum_walk=file.momentum_walk,
        at_rest=file.at_rest,
        orbit=orbit,
        structure=file.structure,
        sensors=file.sensors,
        tolerances=file.tolerances.in_si(bodies.joints, place),
        warnings=(
            *urdf.warnings,
            *_on_a_table(urdf, file),
            *_nonphysical_links(tree, bodies),
            *wheel_warnings,
            *uncoupled,
            *contradictions(bodies.names, bodies.theta, file.structure),
        ),
        document=document,
        urdf=text,
    )


def _on_a_table(urdf: Urdf, file: RobotFile) -> list[str]:
    # Elsewhere than above the base such a joint was refused.
    planar = [joint.name for joint in urdf.joints if joint.kind == "planar"]
    if file.motion == "planar" or not planar:
        return []
    return [
        f"joint '{planar[0]}' above the base is planar: if the robot floats on a "
        "table, give motion: planar in a robot file"
    ]


def _wheels(
    file: RobotFile, tree: LinkTree, place: str
) -> tuple[tuple[Wheel, ...], list[str]]:
    wheels, warnings = [], []
    joints = [entry.joint for entry in file.wheels if entry.joint is not None]
    for i, entry in enumerate(file.wheels):
        where = f"{place}: wheels[{i}]"
        if entry.joint is None:
            wheels.append(_declared(entry))
            continue
        if joints.count(entry.joint) > 1:
            raise InputError(
                f"{where}: joint '{entry.joint}' is a wheel twice; keep one"
            )
        found = rotor(tree, entry.joint, where, entry.inertia)
        wheels.append(Wheel(entry.label, found.axis, found.inertia, entry.mode))
        warnings += found.warnings
    return tuple(wheels), warnings


def _declared(entry: WheelEntry) -> Wheel:
    if entry.axis is None or entry.inertia is None:
        raise InputError("a declared wheel needs axis and inertia")
    axis = np.array(entry.axis)
    return Wheel(entry.label, axis / np.linalg.norm(axis), entry.inertia, entry.mode)


def _limited(
    joints: tuple[Joint, ...], limits: dict[str, LimitEntry], place: str
) -> tuple[Joint, ...]:
    known = [joint.name for joint in joints]
    for name in limits:
        if name not in known:
            raise InputError(
                f"{place}: limits: no joint {name!r}; "
                + suggestion(name, known, "joints")
            )
    return tuple(
        replace(joint, **limits[joint.name].model_dump(exclude_none=True))
        if joint.name in limits
        else joint
        for joint in joints
    )


def _pads(file: RobotFile, bodies: Bodies) -> dict[str, Float[np.ndarray, "3"]]:
    """The middles of pads in body frames; that of the base is at S."""
    origin = {bodies.names[0]: np.array(file.feature_point)}
    return {
        name: np.array(at) - origin.get(name, np.zeros(3))
        for name, at in file.pads.items()
    }


def _require_bodies(
    section: str, named: Iterable[str], bodies: Bodies, place: str
) -> None:
    for name in named:
        if name not in bodies.names:
            raise InputError(
                f"{place}: {section}: no body {name!r}; "
                + suggestion(name, bodies.names, "bodies")
            )


def _nonphysical_links(tree: LinkTree, bodies: Bodies) -> list[str]:
    return [
        fault
        for name in bodies.placements
        for fault in nonphysical(name, tree.links[name].mass, tree.links[name].I_file)
    ]


def _require_mass(bodies: Bodies, place: str) -> None:
    if not bodies.theta[:, 0].sum() > 0:
        raise InputError(
            f"{place}: no link has mass; give nominal values in <inertial>"
        )
