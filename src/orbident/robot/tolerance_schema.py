"""The tolerances of a robot file as pydantic models."""

from collections.abc import Sequence
from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from orbident.errors import InputError
from orbident.files.names import quoted, suggestion
from orbident.files.schema_parts import MappingSchema, WrongValueError
from orbident.robot.description import Joint, Tolerances
from orbident.robot.units import Angle, Length, Share, Time, at_least_zero

EVERY = "*"
"""Instead of a joint's name: what is said of all of them."""

_ZERO_OF = {"revolute": "angle", "prismatic": "length"}


def _zero(value: object) -> object:
    """An angle or a length; it is converted when the joint's kind is known."""
    at_least_zero(value, "angle or length")
    return value


def _by_joint(value: object) -> object:
    if isinstance(value, dict) and not all(isinstance(v, dict) for v in value.values()):
        return {EVERY: value}
    return value


class JointTolerances(MappingSchema):
    """How well an encoder is calibrated, and where the joint is."""

    zero: Annotated[Any, BeforeValidator(_zero)] = 0.0
    scale: Share = 0.0
    place: Length = 0.0
    direction: Angle = 0.0


class WheelTolerances(MappingSchema):
    """How well the wheels' inertia is known."""

    inertia: Share = 0.0


class AttitudeTolerances(MappingSchema):
    """How well the attitude sensor is mounted."""

    misalignment: Angle = 0.0


class GyroTolerances(MappingSchema):
    """How well the gyro is mounted and calibrated."""

    misalignment: Angle = 0.0
    scale: Share = 0.0


class PositionTolerances(MappingSchema):
    """How well the position's scale is calibrated."""

    scale: Share = 0.0


class ClockTolerances(MappingSchema):
    """How late instruments may be shown."""

    joints: Time = 0.0
    attitude: Time = 0.0
    position: Time = 0.0


class TolerancesEntry(MappingSchema):
    """Standard deviations of calibration errors; what is absent is exact."""

    joints: Annotated[dict[str, JointTolerances], BeforeValidator(_by_joint)] = Field(
        default_factory=dict
    )
    feature_point: Length = 0.0
    wheels: WheelTolerances = WheelTolerances()
    attitude: AttitudeTolerances = AttitudeTolerances()
    gyro: GyroTolerances = GyroTolerances()
    position: PositionTolerances = PositionTolerances()
    clocks: ClockTolerances = ClockTolerances()

    def in_si(self, joints: Sequence[Joint], place: str) -> Tolerances:
        """The tolerances of a robot with these joints.

        Raises:
            InputError: there is no such joint, or a joint that turns has a zero in
                metres, or one that slides in radians.
        """
        names = [joint.name for joint in joints]
        for name in self.joints:
            if name not in (*names, EVERY):
                raise InputError(
                    f"{place}: tolerances.joints: no joint {name!r}; "
                    + suggestion(name, names, "joints")
                )
        every = self.joints.get(EVERY, JointTolerances())
        own = {name: self.joints.get(name, every) for name in names}
        return Tolerances(
            joint_zero={
                joint.name: _zero_of(joint, own[joint.name].zero, place)
                for joint in joints
            },
            joint_scale={name: entry.scale for name, entry in own.items()},
            joint_place={name: entry.place for name, entry in own.items()},
            joint_direction={name: entry.direction for name, entry in own.items()},
            wheel_inertia=self.wheels.inertia,
            feature_point=self.feature_point,
            attitude_misalignment=self.attitude.misalignment,
            gyro_misalignment=self.gyro.misalignment,
            gyro_scale=self.gyro.scale,
            position_scale=self.position.scale,
            joint_clock=self.clocks.joints,
            attitude_clock=self.clocks.attitude,
            position_clock=self.clocks.position,
        )


def _zero_of(joint: Joint, zero: object, place: str) -> float:
    try:
        return at_least_zero(zero, _ZERO_OF[joint.kind])
    except WrongValueError as error:
        raise InputError(
            f"{place}: tolerances.joints: the zero of {joint.kind} joint "
            f"'{joint.name}': found {quoted(zero)}; {error}; joints of two kinds need "
            "an entry each, by name"
        ) from None
