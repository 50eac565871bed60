"""A robot as frames with shapes in them: its bodies, and wheels that turn.

Of what no file shows, shapes are made up from what momentum knows of it.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float

from orbident.identified.exported_robot import links_of, wheel_joints
from orbident.robot.description import Robot, Wheel
from orbident.robot.parameters import FIRST_MOMENT, MASS, inertia_about_com
from orbident.scene.shapes import (
    BASE,
    LINKS,
    MARK,
    WHEEL,
    Shape,
    box,
    cylinder,
    link_shapes,
    rod,
    z_towards,
)

DISC = 0.35
"""Radius of a wheel that is only declared, of the base's smallest half extent."""
THIN = 0.025
"""Radius of a rod, of the robot's size."""
STRAIGHT = 0.01
"""Products of inertia below this part of the largest moment turn no box."""


@dataclass(frozen=True, eq=False)
class Scene:
    """What to draw of a robot.

    Frames are the bodies in their order, then the wheels in theirs. A wheel's frame is
    fixed in the base but for turning about its z axis, the spin axis.
    """

    robot: Robot
    shapes: tuple[Shape, ...]
    R_BWheel: Float[np.ndarray, "wheels 3 3"]
    p_BWheel: Float[np.ndarray, "wheels 3"]
    """Position of each wheel from S, base axes, m."""
    size: float
    """The longest way from S along the joints, m."""
    warnings: tuple[str, ...]
    """A sentence where meshes that the URDF names are not shown."""

    @property
    def eye(self) -> Float[np.ndarray, "3"]:
        """Towards the eye, at first; a robot on a table is seen from farther above."""
        return np.array([0.6, -0.8, 1.0 if self.robot.motion == "planar" else 0.5])


def view_axes(eye: Float[np.ndarray, "3"]) -> Float[np.ndarray, "3 3"]:
    """To the right, up and out of a picture, as columns, where z is up."""
    out = eye / np.linalg.norm(eye)
    right = np.cross([0.0, 0.0, 1.0], out)
    right /= np.linalg.norm(right)
    return np.column_stack([right, np.cross(out, right), out])


def scene_of(robot: Robot, folder: Path | None = None) -> Scene:
    """Shapes from the robot's URDF; made up where it shows nothing.

    Meshes are looked for from the folder of the URDF; without one, none is.
    """
    size = robot_size(robot)
    shown, warnings = _shown(robot, folder)
    for body in range(len(robot.bodies)):
        if not any(shape.frame == body for shape in shown):
            shown += made_shapes(robot, body, size)
    base = np.vstack([shape.vertices for shape in shown if shape.frame == 0])
    wheels, shapes = wheel_joints(robot), []
    R = np.reshape([z_towards(wheel.axis) for wheel in robot.wheels], (-1, 3, 3))
    p = np.zeros((len(robot.wheels), 3))
    for k, wheel in enumerate(robot.wheels):
        frame = len(robot.bodies) + k
        own = [shape for shape in shown if shape.frame == frame]
        if own:
            p[k] = wheels[k].p
            shapes += [each.moved(frame, R[k].T, -R[k].T @ p[k]) for each in own]
        else:
            same = [abs(w.axis @ wheel.axis) > 0.99 for w in robot.wheels[:k]]
            p[k], radius = _outside(base, wheel, sum(map(bool, same)))
            disc = cylinder(radius, 0.4 * radius, WHEEL)
            # A bar across the disc shows that it turns.
            bar = box(np.array([1.8, 0.35, 0.5]) * radius, MARK)
            shapes += [shape._replace(frame=frame) for shape in (disc, bar)]
    shapes += [shape for shape in shown if shape.frame < len(robot.bodies)]
    return Scene(robot, tuple(shapes), R, p, size, warnings)


def _shown(robot: Robot, folder: Path | None) -> tuple[list[Shape], tuple[str, ...]]:
    """What the URDF shows, in frames of bodies; of rotors in the base's, but theirs."""
    if not robot.urdf:
        return [], ()
    found = link_shapes(robot.urdf, folder)
    wheel_of = {
        link: k for k, rotor in wheel_joints(robot).items() for link in rotor.links
    }
    shown = []
    _, placements = links_of(robot)
    for link, at in placements.items():
        p = at.p - robot.feature_point if at.body == 0 else at.p
        wheel = wheel_of.get(link)
        frame = at.body if wheel is None else len(robot.bodies) + wheel
        shown += [shape.moved(frame, at.R, p) for shape in found.by_link[link]]
    return shown, found.warnings


def _outside(
    base: Float[np.ndarray, "v 3"], wheel: Wheel, before: int
) -> tuple[Float[np.ndarray, "3"], float]:
    """Where a wheel is seen: on the base's side towards which its axis points."""
    low, high = base.min(axis=0), base.max(axis=0)
    centre, half = (low + high) / 2, (high - low) / 2
    radius = DISC * float(half.min())
    side = float(((base - centre) @ wheel.axis).max())
    return centre + wheel.axis * (side + (0.3 + 0.6 * before) * radius), radius


def robot_size(robot: Robot) -> float:
    """The longest way from S along the joints to a joint or a CM, m."""
    reach = np.zeros(len(robot.bodies))
    for k, joint in enumerate(robot.joints):
        reach[k + 1] = reach[joint.parent] + np.linalg.norm(joint.p_PJ)
    ends = [reach[i] + np.linalg.norm(_com(robot, i)) for i in range(reach.size)]
    base = np.linalg.norm(_even_lengths(robot.theta[0])[0]) / 2
    return float(max(*ends, base)) or 1.0


def made_shapes(robot: Robot, body: int, size: float) -> list[Shape]:
    """A body from what momentum knows of it: joints, CM and inertia.

    The base is the box of even density that has its inertia, with rods to its joints. A
    link is a rod from its joint to each next one; the last one ends as far behind its
    CM as the CM is from its joint. The size is that of the robot, m, whose nominal
    inertia counts.
    """
    com = _com(robot, body)
    joints = [joint.p_PJ for joint in robot.joints if joint.parent == body]
    if body == 0:
        lengths, R = _even_lengths(robot.theta[0])
        base = box(np.maximum(lengths, 0.05 * size), BASE)
        shapes, start, ends, colour = [base.moved(0, R, com)], com, joints, BASE
    else:
        colour = LINKS[(body - 1) % len(LINKS)]
        # A short cylinder along the joint's axis.
        axis = z_towards(robot.joints[body - 1].axis)
        hub = cylinder(1.4 * THIN * size, 3 * THIN * size, BASE)
        shapes = [hub.moved(0, axis, np.zeros(3))]
        start, ends = np.zeros(3), joints or [2 * com]
    shapes += [
        rod(start, end, THIN * size, colour)
        for end in ends
        if np.linalg.norm(end - start) > THIN * size
    ]
    return [shape._replace(frame=body) for shape in shapes]


def _com(robot: Robot, body: int) -> Float[np.ndarray, "3"]:
    theta_i = robot.theta[body]
    return theta_i[FIRST_MOMENT] / theta_i[MASS] if theta_i[MASS] else np.zeros(3)


def _even_lengths(
    theta_i: Float[np.ndarray, "10"],
) -> tuple[Float[np.ndarray, "3"], Float[np.ndarray, "3 3"]]:
    """Side lengths, m, and axes of the box of even density with this inertia."""
    m = theta_i[MASS]
    if m <= 0:
        return np.zeros(3), np.eye(3)
    I = inertia_about_com(theta_i)
    moments, R = np.diag(I), np.eye(3)
    if np.abs(I - np.diag(moments)).max() > STRAIGHT * np.abs(moments).max():
        moments, R = np.linalg.eigh(I)
    # I_k = m/12 (the other two lengths squared)
    squares = 6 / m * (moments.sum() - 2 * moments)
    return np.sqrt(np.maximum(squares, 0.0)), R
