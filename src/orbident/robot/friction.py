"""The friction of joints, as a robot file declares it."""

import math
from collections.abc import Collection, Mapping, Sequence
from typing import Annotated, NamedTuple

from orbident.errors import InputError
from orbident.files.names import suggestion
from orbident.files.schema_parts import Name, keys_of
from orbident.robot.units import (
    FRICTION_OF_A_JOINT,
    TORQUE_OF_A_JOINT,
    Share,
    measure_of,
    quantity_of,
)


class Friction(NamedTuple):
    """What a joint's bearings, seals and gear take of the torque on it.

    At a rate `qd` they take `viscous qd + coulomb sign(qd) + offset`.
    """

    viscous: Annotated[float, measure_of(FRICTION_OF_A_JOINT)] = 0.0
    """N m s, or N s/m of a joint that slides."""
    coulomb: Annotated[float, measure_of(TORQUE_OF_A_JOINT)] = 0.0
    """N m or N."""
    offset: Annotated[float, quantity_of(TORQUE_OF_A_JOINT)] = 0.0
    """Such as what a cable pulls, and the sensor's own zero; N m or N."""
    tolerance: Share | None = None
    """Standard deviation of each of the three, relative; None where they may be
    anything, as friction that nobody has measured may."""

    def std(self, value: float) -> float:
        """Of one of the three, beforehand; infinite where it may be anything."""
        return math.inf if self.tolerance is None else abs(self.tolerance * value)


NO_FRICTION = Friction()
"""Of a joint of which nothing is said: anything may take a part of its torque."""

FrictionSection = dict[Name, Annotated[Friction, keys_of(Friction)]]
"""As a robot file has it: friction by joint."""


def check_friction(
    friction: Mapping[str, Friction],
    joints: Sequence[str],
    passive: Collection[str],
    place: str,
) -> None:
    """Refuse friction of joints that a robot does not have, or that nobody drives.

    Args:
        friction: by the names of joints.
        joints: of the robot.
        passive: those that are on springs.
        place: the robot file's name, for messages.

    Raises:
        InputError: there is no such joint, or it is passive.
    """
    for name in friction:
        if name not in joints:
            raise InputError(
                f"{place}: friction: no joint {name!r}; "
                + suggestion(name, joints, "joints")
            )
        if name in passive:
            raise InputError(
                f"{place}: friction.{name}: the joint is passive, and its damping is "
                "among 'passive'; leave out one"
            )
