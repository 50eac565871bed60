"""What an agent is: something that acts on a robot from outside.

For the simulator it is loads on bodies, as the environment of a file gives them; for
the fit it is disturbances at size one, whose sizes are unknown. Torques are about S,
accelerations those of all parts alike.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import ClassVar, NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.environment.motion import Effect, Load, RobotMotion, Vectors
from orbident.errors import InputError
from orbident.orbits.orbit import Arc
from orbident.trajectories.environment import Environment

AXES = "xyz"

Named = Iterator[tuple[str, Vectors]]
"""Vectors at the nodes of a motion, by name."""


@dataclass(frozen=True)
class World:
    """What acts on one flight."""

    environment: Environment
    """As it was given."""
    arc: Arc | None = None
    """The robot's course in orbit; None where it is not said to be in one."""
    drawn: Mapping[str, Callable[..., Vectors]] = field(default_factory=dict)
    """What is random, by the environment's name of it, at any times, s."""

    def sun(self, t: Float[np.ndarray, " n"]) -> Float[np.ndarray, "n 3"]:
        """The sun's direction, as it is given or by date, inertial axes.

        Raises:
            InputError: no direction is given, and no orbit with an epoch.
        """
        given = self.environment.solar_pressure
        if given is not None and given.sun is not None:
            return np.tile(np.array(given.sun) / np.linalg.norm(given.sun), (t.size, 1))
        if self.arc is None or self.arc.epoch is None:
            raise InputError(
                "environment: solar_pressure: where the sun is, is not known; add sun: "
                "[x, y, z], or an orbit with an epoch"
            )
        return self.arc.sun(t)


class Disturbance(NamedTuple):
    """One number that says how large something from outside is."""

    name: str
    """Such as `tilt.x`."""
    group: str
    """What is there or not there together."""
    unit: str
    effect: Effect
    positive: bool = False
    """Whether less than zero is impossible."""
    std: float = 1.0
    """The number's standard deviation beforehand, in its unit, where the agent is of
    size one."""
    by_place: Float[np.ndarray, "3 3"] | None = None
    """`E` of a pull `E (r_cm - r_cm(0))`, whose `effect` has the CM by CAD; None where
    the CM's place makes no difference."""


class Agent:
    """Something that acts from outside."""

    group: ClassVar[str]
    """The name that robot files and results have for it; a recording has all of the
    numbers of a group among its unknowns, or none."""
    words: ClassVar[str] = ""
    """What acts; empty for what is not tested for."""
    needs: ClassVar[str] = ""
    """Without which nothing shows of it, in words."""
    remedy: ClassVar[str] = ""
    """What to look at before it is believed."""
    unit: ClassVar[str] = "N m"
    """SI: of its numbers."""
    mean: ClassVar[str] = ""
    """The group that is its mean, and stands beside it."""
    slow: ClassVar[bool] = False
    """Whether it follows whatever changes slowly."""
    alike: ClassVar[tuple[str, ...]] = ()
    """Groups that it can be taken for, of the same unit."""
    density: ClassVar[str] = ""
    """The field of `MomentumWalk` that says how strong it is; empty for an agent that
    is no random walk of the momentum."""

    def loads(self, world: World, motion: RobotMotion) -> Iterator[Load]:
        """What it does to a flight: always at the same points of the same bodies."""
        yield from ()

    def columns(self, motion: RobotMotion) -> Iterator[Disturbance]:
        """What of it may show in a recording, each number at size one."""
        for name, torque in self.torques(motion):
            yield self.column(name, motion.turning(torque))

    def torques(self, motion: RobotMotion) -> Named:
        """Those of its columns that only turn: torques about S, inertial axes."""
        yield from ()

    def column(
        self, name: str, effect: Effect, unit: str = "", positive: bool = False
    ) -> Disturbance:
        """One of its numbers, by default in the agent's unit."""
        name = f"{self.group}.{name}"
        return Disturbance(name, self.group, unit or self.unit, effect, positive)
