"""A robot whose reaction wheels are bodies of their own, for the oracles."""

from dataclasses import replace

import numpy as np

from orbident.robot.description import Joint, Robot
from orbident.robot.parameters import PER_BODY, from_mass_com_inertia, transformed


def wheels_as_joints(robot: Robot, seed: int = 0) -> Robot:
    """Each wheel a balanced rotor on a joint after the robot's own.

    What it weighs, anywhere on the base, is taken out of the base, where the robot
    counts it.
    """
    random = np.random.default_rng(seed)
    theta = np.concatenate([robot.theta, np.zeros((len(robot.wheels), PER_BODY))])
    joints = list(robot.joints)
    for wheel in robot.wheels:
        across = np.eye(3) - np.outer(wheel.axis, wheel.axis)
        # Across its axis a rotor has at least half of its inertia.
        I = wheel.inertia * (np.outer(wheel.axis, wheel.axis) + 0.6 * across)
        p = 0.3 * random.standard_normal(3)
        rotor = from_mass_com_inertia(0.3, np.zeros(3), I)
        theta[0] -= transformed(rotor, np.eye(3), p)
        joints.append(Joint(wheel.name, "revolute", 0, wheel.axis, np.eye(3), p))
        theta[len(joints)] = rotor
    return replace(
        robot,
        bodies=(*robot.bodies, *robot.wheel_names),
        joints=tuple(joints),
        theta=theta,
        wheels=(),
    )
