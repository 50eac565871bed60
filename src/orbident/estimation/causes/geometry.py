"""Suspects in the robot file: where joints are, how their axes and the wheels' lie."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from orbident.estimation.causes.suspects import Numbers, Suspect
from orbident.estimation.problem import MomentumProblem
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import Joint, Robot, Wheel

SMALL = 1e-4
"""m or rad."""


def geometry(problem: MomentumProblem) -> Iterator[Suspect]:
    """Every joint's place and axis, and every wheel's axis."""
    robot, planar = problem.robot, problem.robot.motion == "planar"
    for k, joint in enumerate(robot.joints):
        yield _place(k, joint, planar)
        if not planar:
            yield _axis(k, joint)
    if not planar:
        for k, wheel in enumerate(robot.wheels):
            yield _wheel_axis(k, wheel)


def _place(k: int, joint: Joint, planar: bool) -> Suspect:
    """In the plane, its two coordinates there."""
    axes = np.eye(3)[: 2 if planar else 3]
    if joint.kind == "prismatic":
        # Along it, a place is the joint's zero.
        axes = _across(joint.R_PJ @ joint.axis)[: 1 if planar else 2]

    def words(c: Numbers) -> str:
        off = 1e3 * c @ axes
        numbers = ", ".join(f"{x:.2g}" for x in off)
        return (
            f"the place of joint {joint.name} on its link in the robot file, so the "
            f"geometry or length of that link, is off by [{numbers}] mm"
        )

    def corrected(problem: MomentumProblem, c: Numbers) -> MomentumProblem:
        moved = replace(problem.robot.joints[k], p_PJ=joint.p_PJ + c @ axes)
        return _with_joint(problem, k, moved)

    return Suspect(words, np.full(len(axes), SMALL), corrected)


def _axis(k: int, joint: Joint) -> Suspect:
    across = _across(joint.axis)

    def words(c: Numbers) -> str:
        angle = np.degrees(np.linalg.norm(c))
        return (
            f"the axis of joint {joint.name} in the robot file is tilted by "
            f"{angle:.2g} deg"
        )

    def corrected(problem: MomentumProblem, c: Numbers) -> MomentumProblem:
        R = joint.R_PJ @ Rotation.from_rotvec(c @ across).as_matrix()
        return _with_joint(problem, k, replace(problem.robot.joints[k], R_PJ=R))

    return Suspect(words, np.full(2, SMALL), corrected)


def _wheel_axis(k: int, wheel: Wheel) -> Suspect:
    across = _across(wheel.axis)

    def words(c: Numbers) -> str:
        angle = np.degrees(np.linalg.norm(c))
        return (
            f"the axis of wheel {wheel.name} in the robot file is tilted by "
            f"{angle:.2g} deg"
        )

    def corrected(problem: MomentumProblem, c: Numbers) -> MomentumProblem:
        axis = Rotation.from_rotvec(c @ across).apply(wheel.axis)
        wheels = list(problem.robot.wheels)
        wheels[k] = replace(wheels[k], axis=axis)
        robot = replace(problem.robot, wheels=tuple(wheels))
        return replace(problem, robot=robot)

    return Suspect(words, np.full(2, SMALL), corrected)


def _across(axis: Float[np.ndarray, "3"]) -> Float[np.ndarray, "2 3"]:
    """Two directions across an axis; the first in the plane, where the axis is."""
    first = np.cross(axis, [0.0, 0.0, 1.0])
    if np.linalg.norm(first) < 0.1:
        first = np.cross(axis, [1.0, 0.0, 0.0])
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(axis, first)])


def _with_joint(problem: MomentumProblem, k: int, joint: Joint) -> MomentumProblem:
    joints = list(problem.robot.joints)
    joints[k] = joint
    robot: Robot = replace(problem.robot, joints=tuple(joints))
    return replace(problem, robot=robot, sets=minimal_sets(robot))
