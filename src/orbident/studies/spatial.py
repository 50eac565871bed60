"""Section 4: the spatial three-joint servicer, from Table 1 to Table 4.

Whether an installation works: the paper's robot, simulated and identified.
"""

import time
from dataclasses import dataclass

import numpy as np

from orbident.estimation.identify import identify
from orbident.estimation.least_squares import LeastSquares
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate
from orbident.studies import paper_tables
from orbident.trajectories.trajectory import InitialState, Trajectory


def spatial_robot() -> Robot:
    """Table 1's servicer."""
    return load_robot("paper-spatial")


def spatial_trajectory(robot: Robot) -> Trajectory:
    """Table 2's exciting trajectory with Table 3's initial conditions."""
    at_rest = np.zeros((len(robot.joints), 3))
    speeds = {
        wheel.name: momentum / wheel.inertia
        for wheel, momentum in zip(
            robot.wheels, paper_tables.SPATIAL_WHEEL_MOMENTUM, strict=True
        )
    }
    return Trajectory(
        duration=paper_tables.SPATIAL_DURATION,
        joints=robot.joint_names,
        a=np.array(paper_tables.SPATIAL_A),
        b=np.array(paper_tables.SPATIAL_B),
        start=at_rest,
        end=at_rest,
        initial=InitialState(
            angular_velocity=np.array(paper_tables.SPATIAL_ANGULAR_VELOCITY),
            attitude=np.array(paper_tables.SPATIAL_ATTITUDE),
            wheel_speed=speeds,
        ),
        source="Table 2",
    )


LARGEST_ERROR = 1e-6
"""Relative. Without noise only rounding is left, some 1e-14."""


@dataclass(frozen=True)
class SelfTest:
    """What came out."""

    robot: str
    parameters: int
    error: float
    """The largest error of a base parameter, relative to the true value."""
    seconds: float

    @property
    def passed(self) -> bool:
        """Whether every parameter was found."""
        # Not a number is no small error.
        return bool(self.error < LARGEST_ERROR)


def self_test() -> SelfTest:
    """Identifies the bundled robot of the paper's spatial study, without noise."""
    start = time.monotonic()
    robot = spatial_robot()
    recording = simulate(robot, spatial_trajectory(robot))
    base = identify(robot, recording, LeastSquares()).base
    scale = np.where(base.nominal == 0, np.abs(base.nominal).max(), base.nominal)
    error = float(np.max(np.abs((base.values - base.nominal) / scale)))
    return SelfTest(robot.name, len(base.names), error, time.monotonic() - start)
