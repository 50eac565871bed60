"""How well a robot's instruments are calibrated."""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Tolerances:
    """Standard deviations of calibration errors; zero where there are none."""

    joint_zero: Mapping[str, float] = field(default_factory=dict)
    """Angle or position where the encoder shows zero, by joint, rad or m."""
    joint_scale: Mapping[str, float] = field(default_factory=dict)
    """Scale of the encoder by joint, relative."""
    joint_place: Mapping[str, float] = field(default_factory=dict)
    """Place of a joint along each of its parent's axes, by joint, m."""
    joint_direction: Mapping[str, float] = field(default_factory=dict)
    """Direction of a joint's axis about each of its parent's axes, by joint, rad."""
    wheel_inertia: float = 0.0
    """Polar moment of inertia of each wheel, relative."""
    feature_point: float = 0.0
    """Distance of the tracked point from `S`, along each base axis, m."""
    attitude_misalignment: float = 0.0
    """Turn of the attitude sensor's axes from the base's, about each axis, rad."""
    gyro_misalignment: float = 0.0
    """Turn of the gyro's axes from the base's, about each axis, rad."""
    gyro_scale: float = 0.0
    """Scale of each axis of the gyro, relative."""
    position_scale: float = 0.0
    """Scale of the position, relative."""
    joint_clock: float = 0.0
    """How much joints and wheels are shown late, s."""
    attitude_clock: float = 0.0
    """How much the attitude is shown late, s."""
    position_clock: float = 0.0
    """How much the position is shown late, s."""
