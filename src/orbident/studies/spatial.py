"""Section 4: the spatial three-joint servicer, from Table 1 to Table 4."""

import numpy as np

from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.studies import paper_tables
from orbident.trajectories.trajectory import InitialState, Trajectory

PRINTED = 0.005
"""Half of the last of the two decimals that Table 4 prints."""


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
