"""Results of different robots are not compared; the first difference is named."""

from dataclasses import replace

import numpy as np
import pytest

from orbident.errors import InputError
from orbident.identified.difference import check_same_robot
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot("paper-spatial")


def test_inertia_and_structure_may_differ(robot):
    check_same_robot(robot, replace(robot, theta=2 * robot.theta, structure={}))
    moved = replace(robot.joints[2], p_PJ=robot.joints[2].p_PJ + 1e-12)
    check_same_robot(robot, replace(robot, joints=(*robot.joints[:2], moved)))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"kind": "prismatic"}, "kind: revolute before, prismatic after"),
        ({"parent": 1}, "parent: link2 before, link1 after"),
        ({"axis": np.array([1.0, 0, 0])}, r"axis: \[.*\] before, \[1, 0, 0\] after"),
        (
            {"p_PJ": np.array([2.0, 0, 1e-6])},
            r"position \(m\): .*\[2, 0, 1e-06\] after",
        ),
        ({"R_PJ": -np.eye(3)}, r"rotation matrix: .*\[-1, -0, -0, -0, -1"),
    ],
)
def test_joints(robot, changes, words):
    joint = replace(robot.joints[2], **changes)
    other = replace(robot, joints=(*robot.joints[:2], joint))
    with pytest.raises(InputError, match=f"differ: joint 'joint3': {words}"):
        check_same_robot(robot, other)


def test_wheels_and_feature_point(robot):
    heavier = replace(robot.wheels[1], inertia=0.1800001)
    other = replace(robot, wheels=(robot.wheels[0], heavier, robot.wheels[2]))
    with pytest.raises(InputError, match=r"wheel 'rw_y': inertia .* 0.1800001 after"):
        check_same_robot(robot, other)
    with pytest.raises(InputError, match="wheel 'rw_z' is in the run before only"):
        check_same_robot(robot, replace(robot, wheels=robot.wheels[:2]))
    with pytest.raises(InputError, match="wheel order: 'rw_x', 'rw_y', 'rw_z' before"):
        check_same_robot(robot, replace(robot, wheels=robot.wheels[::-1]))
    with pytest.raises(InputError, match=r"feature point \(m\): \[0, 0, 0\] before"):
        check_same_robot(robot, replace(robot, feature_point=np.array([0, 0, 0.1])))


def test_other_robots(robot):
    with pytest.raises(InputError, match="body 'link1' is in the run before only"):
        check_same_robot(robot, load_robot("dual-arm"))
    with pytest.raises(InputError, match="'link3' is in the run before only"):
        check_same_robot(robot, load_robot("cepheus-like"))
    with pytest.raises(InputError, match="motion: spatial before, planar after"):
        check_same_robot(robot, replace(robot, motion="planar"))
