"""Clean motions as MuJoCo flies them, and those of robots that are not as described."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
from acting_in_mujoco import Acts, Torque
from mujoco_flights import Flight
from recordings import Clean
from scipy.interpolate import CubicSpline
from spoiled import Spoil, Spoiled, spoiled

from orbident.robot.description import Robot
from orbident.robot.sensor_schema import declared_sensors
from orbident.simulation.measure import Truth
from orbident.trajectories.trajectory import Trajectory

DENSE = declared_sensors({"rate": 100.0})
"""Rows at every step of MuJoCo: cubic splines between them are off by 1e-8 at most,
in rad, m and s."""

NOTHING = Torque(np.zeros(3))


@dataclass(frozen=True, eq=False)
class Flown(Clean):
    """A motion that MuJoCo flew."""

    curves: tuple[CubicSpline, ...]
    """Of the fields of the truth, but for torques."""

    def at(self, t: np.ndarray) -> Truth:
        """What is true at any times, s."""
        return _truth(self.curves, t)


def flown(
    clean: Clean,
    robot: Robot | None = None,
    motion: Callable[[Trajectory], Trajectory] = lambda motion: motion,
    acts: Acts = NOTHING,
    **flight: Any,
) -> Flown:
    """The same start and commands.

    Args:
        clean: whose joints and wheels are seen.
        robot: what MuJoCo flies; its joints and wheels begin with those that are seen.
        motion: what becomes of the commands.
        acts: from outside.
        flight: more of a `Flight`.
    """
    assert isinstance(clean.joints, Trajectory)
    speeds = zip(clean.robot.wheel_names, clean.start.wheel_speed, strict=True)
    initial = replace(clean.joints.initial, wheel_speed=dict(speeds))
    commands = motion(replace(clean.joints, initial=initial))
    actual = replace(robot or clean.robot, sensors=DENSE)
    t, true = Flight(actual, commands, acts, **flight).flown
    joints, wheels = len(clean.robot.joints), len(clean.robot.wheels)
    seen = true._replace(
        q=true.q[:, :joints],
        qd=true.qd[:, :joints],
        q_rw=true.q_rw[:, :wheels],
        qd_rw=true.qd_rw[:, :wheels],
    )
    curves = tuple(CubicSpline(t, each) for each in seen[:-1])
    return Flown(
        robot=clean.robot,
        joints=clean.joints,
        start=clean.start,
        t=clean.t,
        true=_truth(curves, clean.t),
        initial_momentum=clean.initial_momentum,
        curves=curves,
    )


def _truth(curves: tuple[CubicSpline, ...], t: np.ndarray) -> Truth:
    true = Truth(*(curve(t) for curve in curves))
    norm = np.linalg.norm(true.attitude, axis=1, keepdims=True)
    return true._replace(attitude=true.attitude / norm)


in_mujoco = cache(flown)
"""The motion of a robot that is exactly as described."""


def flies(change: Callable[[Clean], Flown]) -> Spoil:
    """Something is otherwise in flight, and the recording shows it."""

    def spoil(clean: Clean) -> Spoiled:
        return spoiled(clean, recording=change(clean).recorded())

    return spoil


def of_flown(spoil: Spoil) -> Spoil:
    """What becomes of the motion that MuJoCo flies."""
    return lambda clean: spoil(in_mujoco(clean))
