"""What may be off about instruments and about where joints are: each kind once.

Their equations stand in `calibration.hpp`. An error is named after what it is of:
`joint.elbow.zero`, `wheel.rw1.inertia`, `gyro.scale.x`, `joints.clock`.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, NamedTuple

from orbident.robot.units import (
    ARMATURE_OF_A_JOINT,
    FRICTION_OF_A_JOINT,
    OF_A_JOINT,
    TORQUE_OF_A_JOINT,
)

SPRINGS = "springs"
"""What is unknown of joints that nobody measures."""

FRICTION = "friction"
"""What is unknown of what joints' motors drive against."""

TORQUE_SENSORS = 0.01
"""Scale of a joint's torque sensor, relative: 1 % of full scale is usual."""

TORQUE_CONSTANTS = 0.05
"""Scale of a motor's torque constant, relative: data sheets give twice as much."""


class CalibrationKind(NamedTuple):
    """One kind of error."""

    name: str
    """Of its errors, with `{}` in the place of a joint or a wheel."""
    entry: str
    """Of its tolerance in a robot file: section and key; empty of what is declared with
    a passive joint, a rotor or friction."""
    dimension: str
    """Of the error, as `units` has it."""
    by_axis: bool = False
    """Whether there is one for each of x, y and z."""
    usual: float = 0.0
    """Standard deviation where a robot file says nothing, SI; zero of what a file knows
    or a calibration finds. Sources: docs/robot-file.md."""
    of_all: str = ""
    """What those of all joints or wheels are called, where they are one family."""

    @property
    def family(self) -> str:
        """Of its errors, with `{}` where each joint has one of its own."""
        return self.of_all or self.name

    def names(self, of: str = "") -> tuple[str, ...]:
        """Names of the errors: of one joint or wheel where they have one each."""
        name = self.name.format(of)
        return tuple(f"{name}.{axis}" for axis in "xyz") if self.by_axis else (name,)


def _of_each_joint(*kind: Any, **more: Any) -> Any:
    kinds = {"kind": CalibrationKind(*kind, **more)}
    return field(default_factory=dict, metadata=kinds)


def _of_all(*kind: Any, **more: Any) -> Any:
    return field(default=0.0, metadata={"kind": CalibrationKind(*kind, **more)})


@dataclass(frozen=True)
class Tolerances:
    """Standard deviations of calibration errors; zero where there are none.

    They are in the order of the core's `calibration.hpp`; those of thrusters are not in
    the core, and come last.
    """

    joint_zero: Mapping[str, float] = _of_each_joint(
        *("joint.{}.zero", "joints.zero", OF_A_JOINT), usual=1e-3, of_all="joint zeros"
    )
    """Angle or position where the encoder shows zero, by joint, rad or m."""
    joint_scale: Mapping[str, float] = _of_each_joint(
        *("joint.{}.scale", "joints.scale", "share"), usual=1e-4, of_all="joint scales"
    )
    """Scale of the encoder by joint, relative."""
    wheel_inertia: float = _of_all(
        *("wheel.{}.inertia", "wheels.inertia", "share"),
        usual=2e-3,
        of_all="wheel inertias",
    )
    """Polar moment of inertia of each wheel, relative."""
    wheel_axis: float = _of_all(
        *("wheel.{}.axis", "wheels.axis", "angle", True),
        usual=math.radians(0.1),
        of_all="wheel axes",
    )
    """Direction of each wheel's axis about each base axis, rad."""
    feature_point: float = _of_all("feature_point", "feature_point", "length", True)
    """Distance of the tracked point from `S`, along each base axis, m."""
    attitude_misalignment: float = _of_all(
        "attitude.misalignment", "attitude.misalignment", "angle", True
    )
    """Turn of the attitude sensor's axes from the base's, about each axis, rad."""
    gyro_misalignment: float = _of_all(
        "gyro.misalignment", "gyro.misalignment", "angle", True, usual=1e-3
    )
    """Turn of the gyro's axes from the base's, about each axis, rad."""
    gyro_scale: float = _of_all("gyro.scale", "gyro.scale", "share", True, usual=5e-4)
    """Scale of each axis of the gyro, relative."""
    position_scale: float = _of_all("position.scale", "position.scale", "share")
    """Scale of the position, relative."""
    joint_clock: float = _of_all("joints.clock", "clocks.joints", "time", usual=1e-3)
    """How much joints and wheels are shown late, s."""
    attitude_clock: float = _of_all(
        "attitude.clock", "clocks.attitude", "time", usual=1e-3
    )
    """How much the attitude is shown late, s."""
    position_clock: float = _of_all(
        "position.clock", "clocks.position", "time", usual=1e-3
    )
    """How much position and velocity of `S` are shown late, s."""
    joint_place: Mapping[str, float] = _of_each_joint(
        "joint.{}.place", "joints.place", "length", True
    )
    """Place of a joint along each of its parent's axes, by joint, m."""
    joint_direction: Mapping[str, float] = _of_each_joint(
        "joint.{}.direction", "joints.direction", "angle", True
    )
    """Direction of a joint's axis about each of its parent's axes, by joint, rad."""
    joint_frequency: Mapping[str, float] = _of_each_joint(
        *("joint.{}.frequency", "", "share"), of_all=SPRINGS
    )
    """Frequency of each passive joint; its error is a logarithm."""
    joint_damping: Mapping[str, float] = _of_each_joint(
        *("joint.{}.damping", "", "share"), of_all=SPRINGS
    )
    """Damping of each passive joint; its error is a logarithm."""
    joint_torque_scale: Mapping[str, float] = _of_each_joint(
        *("joint.{}.torque_scale", "joints.torque_scale", "share"),
        usual=TORQUE_SENSORS,
        of_all="torque scales",
    )
    """Scale of the torque sensor, or of the torque constant, by joint, relative."""
    joint_armature: Mapping[str, float] = _of_each_joint(
        "joint.{}.armature", "", ARMATURE_OF_A_JOINT
    )
    """`N (N - 1) J` of the rotor of each joint's motor, kg m^2 or kg."""
    joint_viscous: Mapping[str, float] = _of_each_joint(
        *("joint.{}.viscous", "", FRICTION_OF_A_JOINT), of_all=FRICTION
    )
    """Viscous friction of each joint, N m s or N s/m."""
    joint_coulomb: Mapping[str, float] = _of_each_joint(
        *("joint.{}.coulomb", "", TORQUE_OF_A_JOINT), of_all=FRICTION
    )
    """Coulomb friction of each joint, N m or N."""
    joint_torque_offset: Mapping[str, float] = _of_each_joint(
        *("joint.{}.torque_offset", "", TORQUE_OF_A_JOINT), of_all=FRICTION
    )
    """What is shown of torque at each joint that nothing needs, N m or N."""
    thruster_clock: float = _of_all(
        "thrusters.clock", "clocks.thrusters", "time", usual=0.1
    )
    """How much later than recorded all thrusters switch, s."""
    thruster_pulse: float = _of_all(
        "thrusters.pulse", "thrusters.pulse", "time", usual=0.02
    )
    """How much longer than recorded all of them are on, s."""
    thruster_coupling: float = _of_all(
        "thrusters.coupling", "thrusters.coupling", "share", usual=0.05
    )
    """What each of them loses for every further one that is on, relative."""
    thruster_scale: float = _of_all("thrusters.scale", "thrusters.scale", "share")
    """What all of them give more than is recorded, relative."""


CALIBRATION_KINDS: dict[str, CalibrationKind] = {
    each.name: each.metadata["kind"] for each in fields(Tolerances)
}
"""The kinds of errors by the names of their tolerances."""


EVERY = "*"
"""Instead of a joint's name: what is said of all of them."""
