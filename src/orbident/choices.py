"""Words that a person chooses from, for the functions and for the command alike."""

from enum import StrEnum
from typing import Literal

Method = Literal["maximum-likelihood", "structured", "least-squares", "recursive"]
"""How parameters are estimated."""

InitialMomentum = Literal["unknown", "at-rest", "first-sample"]
"""What is known of the momentum (Section 3.1)."""

Objective = Literal["cond", "d", "a", "e"]
"""What a motion that is designed makes small."""

SensorNoise = Literal["none", "sensors"]
"""Who measures in a simulation."""

StudyNoise = Literal["none", "paper"]
"""What sensors add in a study."""


CauseSearch = Literal["none", "quick", "all"]
"""How long the cause of a refusal is looked for."""


class DisturbanceGroup(StrEnum):
    """What is there or not there together, as the estimators have it."""

    torque = "torque"
    slow_torque = "slow_torque"
    base_torque = "base_torque"
    slow_base_torque = "slow_base_torque"
    wheel_loss = "wheel_loss"
    leak = "leak"
    pull = "pull"
    uneven = "uneven"
    drag = "drag"
    hose = "hose"
    air = "air"
    sunlight = "sunlight"
    dipole = "dipole"
    on_springs = "on_springs"
    torque_walk = "torque_walk"
    force_walk = "force_walk"
