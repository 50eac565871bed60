from dataclasses import replace

import numpy as np
import pytest

from orbident.excitation.conditions import conditions_for
from orbident.excitation.floating import usual_initial, was_at_rest
from orbident.robot.robot_file import load_robot


def test_joints_start_at_zero_or_in_the_middle_of_their_range():
    robot = load_robot("paper-spatial")
    ranges = ((-1.0, 2.0), (0.3, 0.7), (0.0, 3.0))
    joints = tuple(
        replace(joint, position=stops)
        for joint, stops in zip(robot.joints, ranges, strict=True)
    )
    found = conditions_for(replace(robot, joints=joints), 60.0)
    np.testing.assert_allclose(found.start[:, 0], [0.0, 0.5, 1.5])
    np.testing.assert_array_equal(found.start, found.end)


def test_a_joint_without_stops_starts_at_zero():
    robot = load_robot("paper-spatial")
    joints = tuple(replace(joint, position=None) for joint in robot.joints)
    found = conditions_for(replace(robot, joints=joints), 60.0)
    assert not found.start.any()


@pytest.mark.parametrize("name", ["paper-spatial", "cepheus-like"])
@pytest.mark.parametrize("at_rest", [True, False])
def test_the_start_is_as_it_is_asked_for(name: str, at_rest: bool):
    """On a table a robot that tumbles turns about z alone."""
    robot = load_robot(name)
    start = np.zeros((len(robot.joints), 3))
    initial = usual_initial(robot, start, -70.0, at_rest)
    assert set(initial.wheel_speed.values()) == {-70.0}
    assert was_at_rest(robot, initial, start) == at_rest
    in_plane = not np.any(initial.angular_velocity[:2])
    assert in_plane == (robot.motion == "planar")
