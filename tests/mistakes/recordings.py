"""Two robots with declared sensors, and what these record where nothing is wrong."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, Literal

import numpy as np
from clean_recordings import RATE
from clean_recordings import SENSORS as IN_SPACE
from random_motions import random_motion

from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.robot.sensor_schema import declared_sensors
from orbident.simulation.free_floating import BaseState, JointMotion, free_floating
from orbident.simulation.measure import Truth, measure_truth, truth_of
from orbident.simulation.simulate import sample_times

SPACE, TABLE = "paper-spatial", "cepheus-like"
ROBOTS = (SPACE, TABLE)
SEED = 1
WHEEL_SPEED = 100.0
"""rad/s."""

SENSORS: Mapping[str, Mapping[str, Any]] = {
    SPACE: {"rate": RATE, **IN_SPACE},
    # Motion capture.
    TABLE: {
        "rate": 50.0,
        "joints": {"position": 2e-4},
        "wheels": {"position": 2e-4},
        "attitude": {"angle": math.radians(0.02)},
        "position": {"std": 1e-4},
    },
}
"""The declared sensors by robot, SI."""


DESIGN = 0.1
"""A body is up to so much heavier or lighter than its CAD model."""


def designed(robot: Robot) -> Robot:
    """The robot as its CAD model has it: what a user knows of its inertia."""
    random = np.random.default_rng(SEED)
    off = 1 + DESIGN * random.uniform(-1, 1, (len(robot.bodies), 1))
    return replace(robot, theta=off * robot.theta)


@dataclass(frozen=True, eq=False)
class Clean:
    """A motion of a robot that is exactly as described, and how it came about."""

    robot: Robot
    joints: JointMotion
    start: BaseState
    t: np.ndarray
    true: Truth
    """What is true at the times `t`."""
    initial_momentum: Literal["unknown", "at-rest"]

    @property
    def space(self) -> bool:
        """Whether the robot is in space, and not on a table."""
        return self.robot.motion == "spatial"

    def at(self, t: np.ndarray) -> Truth:
        """What is true at other times, s."""
        return motion_of(self.robot, self.joints, self.start, t)

    def recorded(
        self, true: Truth | None = None, sensors: Mapping[str, Any] | None = None
    ) -> Recording:
        """What the sensors show.

        Args:
            true: of another motion at the same times.
            sensors: what is different about them, by sensor.
        """
        robot = self.with_sensors(sensors or {})
        return measure_truth(robot, self.t, true or self.true, SEED)

    def with_sensors(self, sensors: Mapping[str, Any]) -> Robot:
        """The robot with what is different about its sensors, by sensor."""
        declared = self.robot.sensors.model_dump(by_alias=True, exclude_none=True)
        for name, changes in sensors.items():
            declared[name] |= changes
        return replace(self.robot, sensors=declared_sensors(declared))


def motion_of(
    robot: Robot, joints: JointMotion, start: BaseState, t: np.ndarray
) -> Truth:
    """The free-floating motion at any times, s."""
    return truth_of(robot, free_floating(robot, joints, t, start), joints)


@cache
def clean(name: str) -> Clean:
    """80 s in space while the base tumbles, or 20 s on the table from rest."""
    robot = replace(load_robot(name), sensors=declared_sensors(SENSORS[name]))
    space = name == SPACE
    trajectory = random_motion(
        robot,
        seed=SEED,
        duration=80.0 if space else 20.0,
        wheel_speed=WHEEL_SPEED,
        start="turning" if space else "spun up",
    )
    initial = trajectory.initial
    start = BaseState(
        initial.angular_velocity,
        initial.attitude,
        initial.velocity,
        # Three speeds, so that no wheel can pass for another.
        WHEEL_SPEED * np.array([2.0, -1.5, 2.5] if space else [1.0]),
    )
    t = sample_times(trajectory.duration, SENSORS[name]["rate"])
    return Clean(
        robot=robot,
        joints=trajectory,
        start=start,
        t=t,
        true=motion_of(robot, trajectory, start, t),
        initial_momentum="unknown" if space else "at-rest",
    )
