"""Names of what may act on a robot from outside."""

from enum import StrEnum


class DisturbanceGroup(StrEnum):
    """What is there or not there together, as the estimators have it."""

    torque = "torque"
    slow_torque = "slow_torque"
    base_torque = "base_torque"
    slow_base_torque = "slow_base_torque"
    wheel_loss = "wheel_loss"
    pull = "pull"
    uneven = "uneven"
    drag = "drag"
    air = "air"
    sunlight = "sunlight"
    dipole = "dipole"
    torque_walk = "torque_walk"
    force_walk = "force_walk"
