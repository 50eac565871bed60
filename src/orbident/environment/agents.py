"""All agents, in order, and what of them the estimators ask for by their groups."""

from collections.abc import Iterator, Mapping
from typing import Any

from orbident.environment.agent import Agent, Disturbance, World
from orbident.environment.air_table import FilmDrag, LevelPull, UnevenPull
from orbident.environment.motion import Load, RobotMotion
from orbident.environment.orbital import (
    GravityGradient,
    MagneticDipole,
    OrbitalDrag,
    SunlightPressure,
)
from orbident.environment.torques_and_forces import (
    BaseTorque,
    ConstantTorque,
    ForceAtS,
    ForceWalk,
    Push,
    TorqueWalk,
    VaryingBaseTorque,
    VaryingTorque,
    WheelLoss,
)

AGENTS: dict[str, Agent] = {
    agent.group: agent
    for agent in (
        ConstantTorque(),
        VaryingTorque(),
        BaseTorque(),
        VaryingBaseTorque(),
        WheelLoss(),
        ForceAtS(),
        Push(),
        LevelPull(),
        UnevenPull(),
        FilmDrag(),
        GravityGradient(),
        OrbitalDrag(),
        SunlightPressure(),
        MagneticDipole(),
        # Densities are estimated from the last unknowns: their waves are these.
        TorqueWalk(),
        ForceWalk(),
    )
}
"""What acts from outside, by its group."""


class AgentTable(Mapping[str, Any]):
    """One property of the agents that have it, by their groups, at any time."""

    def __init__(self, name: str) -> None:
        self.name = name

    @property
    def _now(self) -> dict[str, Any]:
        each = ((group, getattr(agent, self.name)) for group, agent in AGENTS.items())
        return {group: value for group, value in each if value}

    def __getitem__(self, group: str) -> Any:
        return self._now[group]

    def __iter__(self) -> Iterator[str]:
        return iter(self._now)

    def __len__(self) -> int:
        return len(self._now)


IN_WORDS = AgentTable("words")
"""What acts: all that is tested for, or may be asked for."""

NEEDS = AgentTable("needs")
"""Without which nothing shows of a group."""

STEADY = AgentTable("mean")
"""What has a mean beside, by groups of what changes slowly."""

SLOW = AgentTable("slow")
"""Groups that follow whatever changes slowly."""

WALKS = AgentTable("density")
"""Groups of waves, in the order of `MomentumWalk`."""

PUSH, FILM = Push.group, FilmDrag.group
"""What is not tested for but looked for; and what acts where a robot has pads."""


def loads_of(world: World, motion: RobotMotion) -> list[Load]:
    """All that acts on a flight: always at the same points of the same bodies.

    Args:
        world: what was given to act.
        motion: the flight at some of its times.
    """
    every = AGENTS.values()
    return [load for agent in every for load in agent.loads(world, motion)]


def disturbances(motion: RobotMotion) -> Iterator[Disturbance]:
    """All that may act on this robot, and shows in what was recorded.

    Args:
        motion: the motion that was measured.
    """
    return (each for agent in AGENTS.values() for each in agent.columns(motion))
