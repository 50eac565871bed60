"""What is recorded of the wrenches that act on the base, in one form."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot, Thruster

NET_GAIN = 0.1
"""Standard deviation of a net wrench, over what is recorded: no robot file says it."""


class RecordedWrench(NamedTuple):
    """It acts from a sample until the next; base axes."""

    name: str
    gain: float
    """Standard deviation of its size, over what is recorded."""
    force: Float[np.ndarray, "samples 3"]
    """N."""
    torque: Float[np.ndarray, "samples 3"]
    """About S, N m."""


def recorded_wrenches(robot: Robot, recording: Recording) -> tuple[RecordedWrench, ...]:
    """Wrenches of thrusters, and of all together, without those that never act.

    Raises:
        InputError: a thruster's duty is not within 0 and 1, or its thrust is not in the
            robot file; it is recorded twice; or a force without its torque.
    """
    found = (*_of_thrusters(robot, recording), *_net(recording))
    acting = tuple(each for each in found if each.force.any() or each.torque.any())
    if len(acting) > 1 and any(each.name == "wrench" for each in acting):
        raise InputError(
            f"{recording.source}: the columns 'force.*' are the net force of all "
            "thrusters, and 'thruster.*' are there too: they would count twice; remove "
            "one of them"
        )
    return acting


def _of_thrusters(robot: Robot, recording: Recording) -> Iterator[RecordedWrench]:
    for thruster in robot.thrusters:
        newton = _newton(thruster, recording)
        force = np.outer(newton, thruster.direction)
        arm = thruster.position - robot.feature_point
        name = f"thruster.{thruster.name}"
        yield RecordedWrench(name, thruster.gain, force, np.cross(arm, force))


def _newton(thruster: Thruster, recording: Recording) -> Float[np.ndarray, " samples"]:
    force, duty = (f"thruster.{thruster.name}.{kind}" for kind in ("force", "duty"))
    if not recording.has(duty):
        if recording.has(force):
            return _held(recording.column(force))
        return np.zeros(recording.t.size)
    where = f"{recording.source}: column '{duty}'"
    if recording.has(force):
        raise InputError(f"{where}: '{force}' is there too; remove one of them")
    if thruster.thrust is None:
        raise InputError(
            f"{where}: a duty is a part of the full thrust, which the robot file does "
            f"not say; add 'thrust: 5' (N) to thruster '{thruster.name}'"
        )
    on = _held(recording.column(duty))
    wrong = np.flatnonzero((on < 0) | (on > 1))
    if wrong.size:
        raise InputError(
            f"{where}, row {wrong[0] + 1}: found {on[wrong[0]]:g}; a duty is between 0 "
            "(off) and 1 (full thrust)"
        )
    return on * thruster.thrust


def _net(recording: Recording) -> Iterator[RecordedWrench]:
    force, torque = (_vector(recording, name) for name in ("force", "torque"))
    if torque is None:
        if force is not None and force.any():
            raise InputError(
                f"{recording.source}: 'force.x .y .z' act, and 'torque.x .y .z' (about "
                "S) are missing, without which the momentum is not known; add them, or "
                "give each thruster's own force as 'thruster.NAME.force'"
            )
        return
    yield RecordedWrench(
        "wrench", NET_GAIN, np.zeros_like(torque) if force is None else force, torque
    )


def _vector(recording: Recording, name: str) -> Float[np.ndarray, "samples 3"] | None:
    columns = [f"{name}.{axis}" for axis in "xyz"]
    if not recording.has(*columns):
        return None
    return np.column_stack([_held(recording.column(each)) for each in columns])


def _held(shown: Float[np.ndarray, " samples"]) -> Float[np.ndarray, " samples"]:
    """A number holds until the next; before the first there is nothing."""
    rows = np.where(np.isfinite(shown), np.arange(shown.size), 0)
    return np.nan_to_num(shown[np.maximum.accumulate(rows)])
