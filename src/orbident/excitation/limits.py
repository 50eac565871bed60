"""What an exciting trajectory must not exceed, at any time."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.robot.description import Robot

INFINITE = float("inf")


@dataclass(frozen=True, eq=False)
class Limits:
    """Limits of joints, base and wheels; infinite where there is none."""

    position: Float[np.ndarray, "joints 2"]
    """Lower and upper, rad or m."""
    velocity: Float[np.ndarray, " joints"]
    """Finite: it is what scales the amplitudes. rad/s or m/s."""
    acceleration: Float[np.ndarray, " joints"]
    """rad/s^2 or m/s^2."""
    base_rate: float = INFINITE
    """Norm of the base's angular velocity, rad/s."""
    excursion: float = INFINITE
    """Angle of the base from its first attitude, rad."""
    wheel_speed: float = INFINITE
    """Of every wheel relative to the base, rad/s."""


def limits_of(
    robot: Robot,
    acceleration: float = INFINITE,
    base_rate: float = INFINITE,
    excursion: float = INFINITE,
    wheel_speed: float = INFINITE,
) -> Limits:
    """The limits in the robot file and its URDF, and those that neither can state.

    Args:
        robot: with position and velocity limits of its joints.
        acceleration: of every joint, rad/s^2 or m/s^2.
        base_rate: norm of the base's angular velocity, rad/s.
        excursion: angle of the base from its first attitude, rad.
        wheel_speed: of every wheel relative to the base, rad/s.

    Raises:
        InputError: the robot has no joints, a joint has no velocity limit, or a
            limit is not above zero.
    """
    if not robot.joints:
        raise InputError(
            f"{robot.name}: joints: found none; only moving joints excite a robot"
        )
    for joint in robot.joints:
        if not (joint.velocity is not None and 0 < joint.velocity < INFINITE):
            raise InputError(
                f"{robot.name}: joint '{joint.name}': velocity limit: found "
                f"{joint.velocity}; give one in the URDF or under limits: in the "
                "robot file"
            )
    further = {
        "acceleration": acceleration,
        "base rate": base_rate,
        "excursion": excursion,
        "wheel speed": wheel_speed,
    }
    for name, value in further.items():
        if not value > 0:
            raise InputError(f"{name} limit: found {value:g}; give a number above zero")
    free = (-INFINITE, INFINITE)
    return Limits(
        position=np.array([joint.position or free for joint in robot.joints]),
        velocity=np.array([joint.velocity for joint in robot.joints], dtype=float),
        acceleration=np.full(len(robot.joints), float(acceleration)),
        base_rate=float(base_rate),
        excursion=float(excursion),
        wheel_speed=float(wheel_speed),
    )
