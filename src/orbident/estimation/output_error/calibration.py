"""Errors of instruments and of geometry: unknowns that a recording's rows share.

An error whose tolerance the robot file declares has it as standard deviation
beforehand; without a tolerance it is taken for zero.
"""

from collections.abc import Collection, Iterator, Mapping

import numpy as np

from orbident.estimation.unknowns import Unknown
from orbident.model.minimal_sets import conserved_axes
from orbident.robot.description import Robot

UNIT_OF_ZERO = {"revolute": "rad", "prismatic": "m"}

NOTHING_FREE: Mapping[str, float] = {}

Error = tuple[Unknown, bool]
"""An error, and whether anything that was recorded depends on it."""


def calibrations_of(
    robot: Robot, recorded: Collection[str], free: Mapping[str, float] = NOTHING_FREE
) -> tuple[Unknown, ...]:
    """The errors that act on a recording, in the order of the core's `calibration.hpp`.

    Args:
        robot: with its tolerances.
        recorded: names of the sensors that were recorded.
        free: standard deviations beforehand in place of tolerances, by family; SI.
    """
    every = [
        *_of_joints(robot),
        *_of_wheels(robot),
        *_of_the_base(robot, recorded),
        *_of_geometry(robot),
        *_of_springs(robot),
    ]
    return tuple(
        each._replace(place=float(k), std=free.get(each.family, each.std))
        for k, (each, acts) in enumerate(every)
        if acts
    )


def _error(
    name: str, family: str, unit: str, std: float, acts: bool = True
) -> tuple[Unknown, bool]:
    return Unknown(name, family, unit, std, 0.0), acts


def _of_joints(robot: Robot) -> Iterator[Error]:
    known, unseen = robot.tolerances, {*robot.passive}
    for joint in robot.joints:
        name, unit = f"joint.{joint.name}.zero", UNIT_OF_ZERO[joint.kind]
        std = known.joint_zero.get(joint.name, 0.0)
        yield _error(name, "joint zeros", unit, std, joint.name not in unseen)
    for joint in robot.joint_names:
        std = known.joint_scale.get(joint, 0.0)
        yield _error(
            f"joint.{joint}.scale", "joint scales", "1", std, joint not in unseen
        )


def _of_wheels(robot: Robot) -> Iterator[Error]:
    for name in robot.wheel_names:
        std = robot.tolerances.wheel_inertia
        yield _error(f"wheel.{name}.inertia", "wheel inertias", "1", std)


def _of_the_base(robot: Robot, recorded: Collection[str]) -> Iterator[Error]:
    """In the plane, a misaligned gyro's z axis still shows all of the rate.

    Clocks are behind that of the gyro, or of the attitude where there is no gyro.
    """
    known = robot.tolerances
    turning, moving = conserved_axes(robot)
    tracked = moving if {"position", "velocity"} & set(recorded) else ()
    attitude = turning if "attitude" in recorded else ()
    gyro = turning if "gyro" in recorded else ()
    misaligned = gyro if robot.motion == "spatial" else ()
    blocks: tuple[tuple[str, str, tuple[int, ...], float], ...] = (
        ("feature_point", "m", tracked, known.feature_point),
        ("attitude.misalignment", "rad", attitude, known.attitude_misalignment),
        ("gyro.misalignment", "rad", misaligned, known.gyro_misalignment),
        ("gyro.scale", "1", gyro, known.gyro_scale),
    )
    for name, unit, axes, std in blocks:
        for k, axis in enumerate("xyz"):
            yield _error(f"{name}.{axis}", name, unit, std, k in axes)
    position, both = "position" in recorded, bool(attitude and gyro)
    for name, unit, std, acts in (
        ("position.scale", "1", known.position_scale, position),
        ("joints.clock", "s", known.joint_clock, bool(robot.joints)),
        ("attitude.clock", "s", known.attitude_clock, both),
        ("position.clock", "s", known.position_clock, position),
    ):
        yield _error(name, name, unit, std, acts)


def _of_springs(robot: Robot) -> Iterator[Error]:
    """How fast passive joints swing, and how soon they stop; every joint has a place."""
    for name in robot.joint_names:
        acts = name in robot.passive
        std = robot.passive[name].tolerance if acts else 0.0
        yield _error(f"joint.{name}.frequency", "springs", "1", std, acts)
    for name in robot.joint_names:
        # It may as well be nothing, or twice as much.
        acts = name in robot.passive
        yield _error(f"joint.{name}.damping", "springs", "1", float(acts), acts)


def _of_geometry(robot: Robot) -> Iterator[Error]:
    """Where each joint is, and how its axis points; in the axes of its parent.

    A sliding joint displaced along its axis, and a turning one turned about its axis,
    have another zero and nothing else: the axis nearest to it is left out.
    """
    known = robot.tolerances
    turning, moving = conserved_axes(robot)
    blocks: tuple[tuple[str, str, tuple[int, ...], str, Mapping[str, float]], ...] = (
        ("place", "m", moving, "prismatic", known.joint_place),
        ("direction", "rad", turning, "revolute", known.joint_direction),
    )
    for what, unit, axes, doubles, std in blocks:
        for joint in robot.joints:
            along = int(np.argmax(np.abs(joint.R_PJ @ joint.axis)))
            own, family = std.get(joint.name, 0.0), f"joint.{joint.name}.{what}"
            for k, axis in enumerate("xyz"):
                acts = k in axes and not (joint.kind == doubles and k == along)
                yield _error(f"{family}.{axis}", family, unit, own, acts)
