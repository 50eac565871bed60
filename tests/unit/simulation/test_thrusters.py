from dataclasses import replace

import numpy as np
import pytest
from random_robots import random_robot

from orbident.errors import InputError
from orbident.robot.description import Thruster
from orbident.simulation.outside import Pulse, check_pulses, thrust

X, Y, Z = np.eye(3)
ROBOT = replace(
    random_robot(1, ()),
    feature_point=0.5 * X,
    thrusters=(Thruster("up", 2.5 * X, Y), Thruster("down", -0.5 * X, -Y)),
)


def test_force_and_moment_about_S():
    """`p x F` with p from S; on from `on` until just before `off`."""
    pulses = [Pulse("up", 1.0, 2.0, 3.0), Pulse("down", 1.5, 3.0, 1.0)]
    net = thrust(ROBOT, pulses, np.array([0.9, 1.0, 1.5, 2.0, 3.0]))
    up, down = np.array([[0, 3, 0, 0, 0, 6], [0, -1, 0, 0, 0, 1]])
    np.testing.assert_array_equal(net, np.stack([0 * up, up, up + down, down, 0 * up]))


@pytest.mark.parametrize(
    ("pulses", "message"),
    [
        ([Pulse("upp", 1, 2, 1)], "no thruster 'upp'; did you mean 'up'"),
        ([Pulse("up", 2, 2, 1)], "'up': pulse from 2 to 2 s"),
        ([Pulse("up", 2, 1, 1)], "'up': pulse from 2 to 1 s"),
        ([Pulse("up", -1, 1, 1)], "'up': pulse from -1 to 1 s; .* from 0 to 5 s"),
        ([Pulse("up", 4, 6, 1)], "'up': pulse from 4 to 6 s"),
        ([Pulse("up", np.nan, 6, 1)], "'up': pulse from nan to 6 s"),
        ([Pulse("up", 1, 3, 1), Pulse("up", 2, 4, 1)], "pulses at 1 s and 2 s overlap"),
        ([Pulse("up", 1, 4, 1), Pulse("up", 2, 3, 1)], "pulses at 1 s and 2 s overlap"),
    ],
)
def test_pulses_that_cannot_be_flown(pulses, message):
    with pytest.raises(InputError, match=message) as caught:
        check_pulses(ROBOT, pulses, 0.0, 5.0)
    assert "\n" not in str(caught.value)


def test_pulses_may_touch_and_thrusters_fire_together():
    pulses = [Pulse("up", 1, 2, 1), Pulse("up", 2, 3, 2), Pulse("down", 1, 3, 1)]
    check_pulses(ROBOT, pulses, 0.0, 5.0)
