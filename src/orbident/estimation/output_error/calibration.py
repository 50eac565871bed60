"""Errors of instruments and of geometry: unknowns that a recording's rows share.

Which there are `robot/tolerances.py` says: a new one is a row there, its equations in
the core, and here the axes on which it shows, where these are not all. An error whose
tolerance the robot file declares has it as standard deviation beforehand; without a
tolerance it is taken for zero.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence

import numpy as np

from orbident.environment.agents import FREE
from orbident.estimation.output_error.sensors import torque_column
from orbident.estimation.unknowns import Unknown
from orbident.robot.description import Joint, Robot, Wheel
from orbident.robot.tolerances import CALIBRATION_KINDS
from orbident.robot.units import BY_KIND, si_unit

NOTHING_FREE: Mapping[str, float] = {}

ALL = range(3)
"""Axes; an error that has none is on the first."""

DOUBLES_ZERO = {"prismatic": "joint_place", "revolute": "joint_direction"}
"""By the kind of a joint, the error that, along its axis, is an error of its zero."""

NEITHER_OF = {"joint_zero": True, "joint_scale": True} | {
    "joint_frequency": False,
    "joint_damping": False,
}
"""Errors that joints do not have which are passive, or which are not: a passive joint
has a spring and no encoder."""

OF_TORQUES = (
    *("joint_torque_scale", "joint_armature"),
    *("joint_viscous", "joint_coulomb", "joint_torque_offset"),
)
"""Errors that joints have whose torque is measured."""


def calibrations_of(
    robot: Robot, recorded: Collection[str], free: Mapping[str, float] = NOTHING_FREE
) -> tuple[Unknown, ...]:
    """The errors that act on a recording, in the order of the core's `calibration.hpp`.

    Args:
        robot: with its tolerances.
        recorded: names of the sensors that were recorded, what was seen of thrust
            (`thrust_seen`), and columns of the torques that count.
        free: standard deviations beforehand in place of tolerances, by family or by
            name; SI.
    """
    shown = _axes_that_show(robot, recorded)
    every = [
        (error, axis in shown.get(tolerance, ALL) and axis not in hidden)
        for tolerance in CALIBRATION_KINDS
        for errors, hidden in _errors(robot, tolerance, recorded)
        for axis, error in enumerate(errors)
    ]
    return tuple(
        each._replace(
            place=float(k), std=free.get(each.name, free.get(each.family, each.std))
        )
        for k, (each, acts) in enumerate(every)
        if acts
    )


def _errors(
    robot: Robot, tolerance: str, recorded: Collection[str]
) -> Iterator[tuple[Sequence[Unknown], Collection[int]]]:
    """The errors of one kind of each joint or wheel, and axes that show nothing."""
    kind, std = CALIBRATION_KINDS[tolerance], getattr(robot.tolerances, tolerance)
    owners: Mapping[str, Joint | Wheel | None] = {"": None}
    if kind.name.startswith("joint."):
        owners = {joint.name: joint for joint in robot.joints}
    elif kind.name.startswith("wheel."):
        owners = {wheel.name: wheel for wheel in robot.wheels}
    for name, owner in owners.items():
        own = min(std.get(name, 0.0) if isinstance(std, Mapping) else std, FREE)
        dimension, family = kind.dimension, kind.family.format(name)
        if isinstance(owner, Joint):
            dimension = BY_KIND.get(dimension, {}).get(owner.kind, dimension)
        hidden = _along_itself(tolerance, owner)
        if NEITHER_OF.get(tolerance) is (name in robot.passive):
            hidden = {*ALL}
        if tolerance in OF_TORQUES and torque_column(name) not in recorded:
            hidden = {*ALL}
        unit = si_unit(dimension)
        yield (
            [Unknown(each, family, unit, own, 0.0) for each in kind.names(name)],
            hidden,
        )


def _along_itself(tolerance: str, owner: Joint | Wheel | None) -> Collection[int]:
    """The axis nearest to that of a joint or wheel, where an error along it is another.

    A sliding joint displaced along its axis, and a turning one turned about its axis,
    have another zero and nothing else; a wheel turned about its axis has nothing.
    """
    match owner:
        case Joint() if tolerance == DOUBLES_ZERO[owner.kind]:
            axis = owner.R_PJ @ owner.axis
        case Wheel() if tolerance == "wheel_axis":
            axis = owner.axis
        case _:
            return ()
    return {int(np.argmax(np.abs(axis)))}


def _axes_that_show(
    robot: Robot, recorded: Collection[str]
) -> Mapping[str, Sequence[int]]:
    """The axes on which errors show, by their tolerance; all of those not named.

    In the plane, a misaligned gyro's z axis still shows all of the rate. Clocks are
    behind that of the gyro, or of the attitude where there is no gyro.
    """
    turning, moving = robot.conserved_axes
    gyro, attitude, position, velocity = (
        name in recorded for name in ("gyro", "attitude", "position", "velocity")
    )

    def where(seen: bool, axes: Sequence[int] = ALL) -> Sequence[int]:
        return axes if seen else ()

    return {
        "wheel_axis": where(robot.motion == "spatial"),
        "feature_point": where(position or velocity, moving),
        "attitude_misalignment": where(attitude, turning),
        "gyro_misalignment": where(gyro and robot.motion == "spatial", turning),
        "gyro_scale": where(gyro, turning),
        "position_scale": where(position),
        "joint_clock": where(bool(robot.joints)),
        "attitude_clock": where(attitude and gyro),
        "position_clock": where(position or velocity),
        "thruster_clock": where("thrusters" in recorded),
        "thruster_pulse": where("thrusters" in recorded),
        "thruster_coupling": where("thrusters together" in recorded),
        "thruster_scale": where("thrusters" in recorded),
        "joint_place": moving,
        "joint_direction": turning,
    }
