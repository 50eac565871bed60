"""Thruster pulses: on-off forces, and what they amount to about S."""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.files.names import suggestion
from orbident.robot.description import Robot
from orbident.trajectories.environment import Environment, Firing


class Pulse(NamedTuple):
    """One thruster, on for a while at a constant force."""

    thruster: str
    on: float
    """s."""
    off: float
    """s."""
    force: float
    """N."""


def check_pulses(
    robot: Robot, pulses: Sequence[Pulse], start: float, end: float
) -> None:
    """Refuse a schedule that no thruster can fly.

    Raises:
        InputError: a thruster is unknown, a pulse is empty, outside of the run or
            pulls, or two pulses of one thruster overlap.
    """
    names = [thruster.name for thruster in robot.thrusters]
    for pulse in pulses:
        where = f"{robot.name}: thruster '{pulse.thruster}'"
        if pulse.thruster not in names:
            raise InputError(
                f"{robot.name}: no thruster '{pulse.thruster}'; "
                + suggestion(pulse.thruster, names, "thrusters")
            )
        if not 0 <= pulse.force < np.inf:
            raise InputError(
                f"{where}: force {pulse.force:g} N; a thruster only pushes, give a "
                "positive force"
            )
        if not start <= pulse.on < pulse.off <= end:
            raise InputError(
                f"{where}: pulse from {pulse.on:g} to {pulse.off:g} s; it must end "
                f"after it begins, within the run from {start:g} to {end:g} s"
            )
    for first, second in pairwise(sorted(pulses)):
        if first.thruster == second.thruster and second.on < first.off:
            raise InputError(
                f"{robot.name}: thruster '{first.thruster}': the pulses at "
                f"{first.on:g} s and {second.on:g} s overlap; join them"
            )


def thrust(
    robot: Robot, pulses: Sequence[Pulse], t: Float[np.ndarray, " n"]
) -> Float[np.ndarray, "n 6"]:
    """Net force on the base and its moment about S, base axes, N and N m.

    Args:
        robot: whose thrusters fire.
        pulses: checked; each is on from `on` until just before `off`.
        t: times, s.
    """
    net = np.zeros((t.size, 6))
    by_name = {thruster.name: thruster for thruster in robot.thrusters}
    for name, on, off, force in pulses:
        thruster = by_name[name]
        arm = thruster.position - robot.feature_point
        unit = np.append(thruster.direction, np.cross(arm, thruster.direction))
        net += np.where((on <= t) & (t < off), force, 0.0)[:, None] * unit
    return net


def true_pulses(environment: Environment) -> tuple[Pulse, ...]:
    """What the thrusters do: the recorded force times the gain."""
    return tuple(
        Pulse(name, pulse.on, pulse.off, thrust.gain * pulse.force)
        for name, thrust in environment.thrusters.items()
        for pulse in thrust.pulses
    )


def thrust_columns(
    environment: Environment, t: Float[np.ndarray, " rows"]
) -> dict[str, Float[np.ndarray, " rows"]]:
    """The columns that a recording has of them, N.

    A number holds until the next row: it is the mean over that time, and the impulse is
    right wherever a pulse begins.

    Args:
        environment: with the thrusters.
        t: the times of the rows, s.
    """
    return {
        f"thruster.{name}.force": sum(
            (_mean(pulse, t) for pulse in thrust.pulses), np.zeros(t.size)
        )
        for name, thrust in environment.thrusters.items()
    }


def _mean(pulse: Firing, t: Float[np.ndarray, " rows"]) -> Float[np.ndarray, " rows"]:
    since = np.clip(t, pulse.on, pulse.off)
    return np.append(pulse.force * np.diff(since) / np.diff(t), 0.0)
