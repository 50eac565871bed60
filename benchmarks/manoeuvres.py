"""The manoeuvres that are timed."""

from dataclasses import replace

import numpy as np

from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.trajectories.trajectory import InitialState, Trajectory

WHEEL_SPEED = 200.0
"""rad/s."""


def dual_arm() -> Robot:
    """Two arms of seven joints and three wheels: the largest bundled robot.

    Without stops: no motion within them shows all of its 496 `pi` beyond rounding.
    """
    robot = load_robot("dual-arm")
    joints = tuple(replace(joint, position=None) for joint in robot.joints)
    turning = robot.urdf.replace('type="revolute"', 'type="continuous"')
    return replace(robot, joints=joints, urdf=turning)


def excitation(robot: Robot, duration: float = 60.0, harmonics: int = 5) -> Trajectory:
    """Every joint at once, over rates up to 0.5 rad/s, with all wheels spinning."""
    random = np.random.default_rng(0)
    a, b = random.normal(0.0, 0.15, (2, len(robot.joints), harmonics))
    at_rest = np.zeros((len(robot.joints), 3))
    speeds = {name: WHEEL_SPEED for name in robot.wheel_names}
    initial = InitialState(np.array([0.01, 0.03, 0.025]), wheel_speed=speeds)
    return Trajectory(duration, robot.joint_names, a, b, at_rest, at_rest, initial)
