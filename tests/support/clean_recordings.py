"""A robot in space with good sensors, some of them changed, and what it records."""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from random_motions import random_motion

import orbident as oi
from orbident.robot.sensor_schema import declared_sensors
from orbident.simulation.measure import measure_truth, truth_of
from orbident.simulation.simulate import float_along

RATE = 10.0
"""Hz."""

# The gyro and the encoders of the paper; a good star tracker and a good camera.
SENSORS: dict[str, dict[str, Any]] = {
    "gyro": {
        "angle_random_walk": math.radians(0.01) / 60,
        "bias_instability": math.radians(0.3) / 3600,
    },
    "joints": {"position": 2.5e-5},
    "wheels": {"position": 2.5e-5},
    "attitude": {"angle": math.radians(0.01)},
    "position": {"std": 1e-4},
}


@dataclass(frozen=True, eq=False)
class Recorded:
    """A recording, and the robot whose file describes it rightly."""

    robot: oi.Robot
    recording: oi.Recording

    @property
    def gyro_std(self) -> float:
        """Standard deviation of the gyro's white noise in a sample, rad/s."""
        return self.robot.sensors.of("gyro").white_std(1 / RATE)

    def z(self, result: oi.Result) -> np.ndarray:
        """Errors of the base parameters over their deviations."""
        beta = oi.minimal_sets(self.robot).beta(self.robot.theta)
        return (result.base.values - beta) / result.base.std


def clean_space(seed: int, duration: float = 80.0, **sensors: Any) -> Recorded:
    """`paper-spatial`, tumbling, wheels spinning; `sensors` stand instead of others."""
    kept = {**SENSORS, **sensors}
    declared = declared_sensors({"rate": RATE, **kept})
    robot = replace(oi.load_robot("paper-spatial"), sensors=declared)
    trajectory = random_motion(
        robot, seed=1, duration=duration, wheel_speed=100.0, start="turning"
    )
    motion = float_along(robot, trajectory, RATE)
    true = truth_of(robot, motion, trajectory.for_robot(robot))
    return Recorded(robot, measure_truth(robot, motion.t, true, seed))
