from dataclasses import replace

import numpy as np
import pytest
from random_robots import DUAL_ARM, random_planar_robot, random_robot

from orbident.errors import InputError
from orbident.model.equations_of_motion import check_regular
from orbident.robot.description import Passive, Robot
from orbident.robot.robot_file import bundled_robots, load_robot


def without_mass(robot: Robot, *bodies: int) -> Robot:
    theta = robot.theta.copy()
    theta[list(bodies)] = 0.0
    return replace(robot, theta=theta)


@pytest.mark.parametrize("name", bundled_robots())
def test_bundled_robots_are_regular(name):
    check_regular(load_robot(name))


@pytest.mark.parametrize(
    "robot",
    [
        random_robot(0, ()),
        random_robot(0, DUAL_ARM, prismatic=(1, 5)),
        random_robot(0, DUAL_ARM, base=1e5),
        random_robot(0, DUAL_ARM, base=1e16),
        random_planar_robot(0, (0, 1, 0), prismatic=(1,)),
    ],
    ids=["no-joints", "slides", "heavy-base", "heaviest-base", "planar"],
)
def test_bodies_with_mass_are_regular(robot):
    check_regular(robot)


def test_massless_links_inside_a_chain_are_no_matter():
    check_regular(without_mass(random_robot(0, (0, 1, 2)), 1, 2))


def test_massless_base_is_no_matter():
    """The base's frame alone: the links have all the inertia."""
    check_regular(without_mass(random_robot(0, (0, 1, 0)), 0))


@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_massless_tip_is_refused_by_its_joint(kind):
    robot = random_robot(0, (0, 1, 0), prismatic=(1,) if kind == "prismatic" else ())
    with pytest.raises(InputError, match=r"random-0: .* joint 'joint2' can turn"):
        check_regular(without_mass(robot, 2))


def test_two_joints_about_one_axis_are_refused():
    """A massless link between two joints on the same axis."""
    robot = random_robot(0, (0, 1))
    first, second = robot.joints
    second = replace(second, axis=first.axis, R_PJ=np.eye(3), p_PJ=np.zeros(3))
    robot = without_mass(replace(robot, joints=(first, second)), 1)
    with pytest.raises(InputError, match=r"joint 'joint[12]' can turn"):
        check_regular(robot)


def test_a_spring_behind_a_measured_joint_is_regular():
    """The same, where one of them is moved, whatever the other does."""
    robot = random_robot(0, (0, 1))
    first, second = robot.joints
    second = replace(second, axis=first.axis, R_PJ=np.eye(3), p_PJ=np.zeros(3))
    robot = without_mass(replace(robot, joints=(first, second)), 1)
    robot = replace(robot, passive={second.name: Passive(1.0)})
    check_regular(robot)
    with pytest.raises(InputError, match=r"joint 'joint[12]' can turn"):
        check_regular(without_mass(robot, 1, 2))


def test_a_robot_without_mass_is_refused():
    robot = random_robot(0, (0, 1))
    with pytest.raises(InputError, match="the mass matrix is singular"):
        check_regular(without_mass(robot, 0, 1, 2))
