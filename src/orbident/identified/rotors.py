"""Reaction wheels as bodies of their own, for tools whose wheels are bodies.

A robot counts its wheels in the base (Eq. 5). A wheel that is a joint of the URDF has
the mass and the place that its links have there. Of a wheel that is only declared the
polar inertia is known, and nothing else matters: it is taken as a ball with this
inertia, at the CM of the nominal base, so that the base loses little else.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.identified.urdf_export import links_of
from orbident.robot.description import Robot, Wheel
from orbident.robot.fusing import fused
from orbident.robot.parameters import (
    FIRST_MOMENT,
    MASS,
    PER_BODY,
    from_mass_com_inertia,
    inertia_about_com,
    transformed,
)
from orbident.robot.physical_inertia import nonphysical

LIGHT = 1e-3
"""A declared wheel's part of the robot's mass: no motion depends on it."""


class WheelJoint(NamedTuple):
    """A wheel that is a joint of the URDF."""

    root: str
    """The link that the joint turns,"""
    links: frozenset[str]
    """and all links that turn with it."""
    p: Float[np.ndarray, "3"]
    """Where its joint is from S, base axes, m."""


class RotorBody(NamedTuple):
    """A wheel as a body that turns about its axis through its origin."""

    name: str
    p: Float[np.ndarray, "3"]
    """Its origin from S, base axes, m."""
    theta: Float[np.ndarray, "10"]
    """About its origin, base axes, at a wheel angle of zero."""


def wheel_joints(robot: Robot) -> dict[int, WheelJoint]:
    """Wheels that the URDF has as joints, by the index of the wheel."""
    entries = enumerate(robot.document.get("wheels", ()))
    joints = {entry["joint"]: k for k, entry in entries if "joint" in entry}
    if not joints:
        return {}
    links = links_of(robot)
    found = {}
    for joint in (each for below in links.tree.children.values() for each in below):
        if joint.name in joints:
            below = frozenset(fused(links.tree, joint.child).placements)
            p = links.placements[joint.child].p - robot.feature_point
            found[joints[joint.name]] = WheelJoint(joint.child, below, p)
    return found


def rotor_bodies(robot: Robot) -> tuple[RotorBody, ...]:
    """The robot's wheels, in their order, as bodies that can exist.

    Raises:
        InputError: the robot was not loaded from a URDF.
    """
    joints = wheel_joints(robot)
    return tuple(
        _rotor_body(robot, wheel, joints.get(k)) for k, wheel in enumerate(robot.wheels)
    )


def parts_of_base(
    robot: Robot, rotors: tuple[RotorBody, ...]
) -> Float[np.ndarray, "bodies 10"]:
    """What the rotors add to each body's `theta`: to the base alone."""
    parts = np.zeros_like(robot.theta)
    for rotor in rotors:
        parts[0] += transformed(rotor.theta, np.eye(3), rotor.p)
    return parts


def _rotor_body(robot: Robot, wheel: Wheel, joint: WheelJoint | None) -> RotorBody:
    theta = np.zeros(PER_BODY) if joint is None else _of_links(robot, joint)
    # What a URDF says of a rotor need not be possible.
    if joint is not None and theta[MASS] > 0:
        faults = nonphysical(wheel.name, theta[MASS], inertia_about_com(theta))
        if not faults:
            return RotorBody(joint.root, joint.p, theta)
    m = robot.theta[0, MASS]
    at_com = robot.theta[0, FIRST_MOMENT] / m if m > 0 else np.zeros(3)
    ball = from_mass_com_inertia(
        LIGHT * robot.mass, np.zeros(3), wheel.inertia * np.eye(3)
    )
    if joint is None:
        return RotorBody(f"{wheel.name}_rotor", at_com, ball)
    return RotorBody(joint.root, joint.p, ball)


def _of_links(robot: Robot, joint: WheelJoint) -> Float[np.ndarray, "10"]:
    links = links_of(robot)
    theta = np.zeros(PER_BODY)
    for name in joint.links:
        at = links.placements[name]
        p = at.p - robot.feature_point - joint.p
        theta += transformed(links.tree.links[name].theta, at.R, p)
    return theta
