"""Calibration errors of instruments: what a recording's equations have in common.

An error whose tolerance the robot file declares is an unknown with a prior; without a
tolerance it is zero.
"""

from collections.abc import Collection, Iterator, Mapping

import numpy as np

from orbident.estimation.unknowns import Calibration, Unit
from orbident.model.minimal_sets import conserved_axes
from orbident.robot.description import Robot

UNIT_OF_ZERO: dict[str, Unit] = {"revolute": "rad", "prismatic": "m"}


def calibrations_of(robot: Robot, recorded: Collection[str]) -> tuple[Calibration, ...]:
    """The calibration errors that act on a recording.

    Args:
        robot: with its tolerances.
        recorded: names of the sensors that were recorded.
    """
    every = [
        *_of_joints(robot),
        *_of_wheels(robot),
        *_of_the_base(robot, recorded),
        *_of_geometry(robot),
    ]
    placed = (each._replace(place=k) for k, each in enumerate(every))
    return tuple(each for each in placed if each.acts)


def _of_joints(robot: Robot) -> Iterator[Calibration]:
    known = robot.tolerances
    for joint in robot.joints:
        std = known.joint_zero.get(joint.name, 0.0)
        yield Calibration(
            f"joint.{joint.name}.zero", UNIT_OF_ZERO[joint.kind], True, std
        )
    for name in robot.joint_names:
        std = known.joint_scale.get(name, 0.0)
        yield Calibration(f"joint.{name}.scale", "1", True, std)


def _of_wheels(robot: Robot) -> Iterator[Calibration]:
    for name in robot.wheel_names:
        std = robot.tolerances.wheel_inertia
        yield Calibration(f"wheel.{name}.inertia", "1", True, std)


def _of_the_base(robot: Robot, recorded: Collection[str]) -> Iterator[Calibration]:
    """In the plane, a misaligned gyro's z axis still shows all of the rate.

    Clocks are behind that of the gyro, or of the attitude where there is no gyro.
    """
    known = robot.tolerances
    turning, moving = conserved_axes(robot)
    tracked = moving if {"position", "velocity"} & set(recorded) else ()
    attitude = turning if "attitude" in recorded else ()
    gyro = turning if "gyro" in recorded else ()
    misaligned = gyro if robot.motion == "spatial" else ()
    blocks: tuple[tuple[str, Unit, tuple[int, ...], float], ...] = (
        ("feature_point", "m", tracked, known.feature_point),
        ("attitude.misalignment", "rad", attitude, known.attitude_misalignment),
        ("gyro.misalignment", "rad", misaligned, known.gyro_misalignment),
        ("gyro.scale", "1", gyro, known.gyro_scale),
    )
    for name, unit, axes, std in blocks:
        for k, axis in enumerate("xyz"):
            yield Calibration(f"{name}.{axis}", unit, k in axes, std)
    yield Calibration(
        "position.scale", "1", "position" in recorded, known.position_scale
    )
    both = bool(attitude and gyro)
    yield Calibration("joints.clock", "s", bool(robot.joints), known.joint_clock)
    yield Calibration("attitude.clock", "s", both, known.attitude_clock)
    yield Calibration(
        "position.clock", "s", "position" in recorded, known.position_clock
    )


def _of_geometry(robot: Robot) -> Iterator[Calibration]:
    """Where each joint is, and how its axis points; in the axes of its parent.

    A sliding joint displaced along its axis, and a turning one turned about its axis,
    have another zero and nothing else: the axis nearest to it is left out.
    """
    known = robot.tolerances
    turning, moving = conserved_axes(robot)
    blocks: tuple[tuple[str, Unit, tuple[int, ...], str, Mapping[str, float]], ...] = (
        ("place", "m", moving, "prismatic", known.joint_place),
        ("direction", "rad", turning, "revolute", known.joint_direction),
    )
    for what, unit, axes, doubles, std in blocks:
        for joint in robot.joints:
            along = int(np.argmax(np.abs(joint.R_PJ @ joint.axis)))
            own = std.get(joint.name, 0.0)
            for k, axis in enumerate("xyz"):
                acts = k in axes and not (joint.kind == doubles and k == along)
                yield Calibration(f"joint.{joint.name}.{what}.{axis}", unit, acts, own)
