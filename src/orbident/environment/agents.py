"""All agents, in order, and what of them the estimators ask for by their groups."""

from collections.abc import Iterator, Mapping

from orbident.environment import air_table, orbital
from orbident.environment import torques_and_forces as steady
from orbident.environment.agent import Agent, Disturbance, World
from orbident.environment.motion import Load, RobotMotion
from orbident.robot.may_act import MayAct

AGENTS: dict[str, Agent] = {
    agent.group: agent
    for agent in (
        steady.ConstantTorque(),
        steady.VaryingTorque(),
        steady.BaseTorque(),
        steady.VaryingBaseTorque(),
        steady.WheelLoss(),
        steady.WheelNoise(),
        steady.ForceAtS(),
        steady.Leak(),
        steady.Push(),
        air_table.LevelPull(),
        air_table.UnevenPull(),
        air_table.FilmDrag(),
        air_table.Hose(),
        orbital.GravityGradient(),
        orbital.OrbitalDrag(),
        orbital.SunlightPressure(),
        orbital.MagneticDipole(),
        steady.OnSprings(),
        # Densities are estimated from the last unknowns: their waves are these.
        steady.TorqueWalk(),
        steady.ForceWalk(),
    )
}
"""What acts from outside, by its group."""

STEADY = {group: each.mean for group, each in AGENTS.items() if each.mean}
"""What has a mean beside, by groups of what changes slowly."""

SLOW = tuple(group for group, each in AGENTS.items() if each.slow)
"""Groups that follow whatever changes slowly."""

WALKS = tuple(group for group, each in AGENTS.items() if each.density)
"""Groups of waves, in the order of `MomentumWalk`."""

NOISE = steady.WheelNoise.group
"""Noise of an instrument, which is not said to act."""

UNTESTED = (*WALKS, NOISE)
"""What is as large as it is declared, so that no more of it is tested for."""

FREE = 1e3
"""SI: standard deviation beforehand of what may be anything."""

PUSH, FILM = steady.Push.group, air_table.FilmDrag.group
"""What is not tested for but looked for; and what acts where a robot has pads."""


def loads_of(world: World, motion: RobotMotion) -> list[Load]:
    """All that acts on a flight: always at the same points of the same bodies."""
    return [x for agent in AGENTS.values() for x in agent.loads(world, motion)]


def disturbances(motion: RobotMotion) -> Iterator[Disturbance]:
    """All that may act on this robot, and shows in what was recorded."""
    return (each for agent in AGENTS.values() for each in agent.columns(motion))


def std_of(disturbance: Disturbance, allowed: Mapping[str, MayAct]) -> float:
    """The standard deviation beforehand of one number of what acts, in its unit.

    Args:
        disturbance: of an agent.
        allowed: what may act, by group; the mean of what changes slowly is as large.
    """
    group, share = disturbance.group, disturbance.std
    if group in WALKS:
        return share
    groups = {group} | {slow for slow, mean in STEADY.items() if mean == group}
    size = max((allowed[each].size for each in groups & allowed.keys()), default=0.0)
    return min(size * share, FREE)
