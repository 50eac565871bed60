import math
import pickle

import numpy as np
import pytest

from orbident.robot.description import Joint, Robot


def test_a_robot_made_by_hand_can_be_sent_to_another_process():
    made = Robot("r", "spatial", ("base",), (), np.ones((1, 10)), np.zeros(3))
    found = pickle.loads(pickle.dumps(made))
    assert (found.structure, found.sensors.declared, found.document) == ({}, {}, {})


@pytest.mark.parametrize(
    ("position", "found"),
    [
        (None, (-3.0, 3.0)),
        ((-1.0, 2.0), (-1.0, 2.0)),
        ((-1.0, math.inf), (-1.0, 5.0)),
        ((-math.inf, 1.0), (-5.0, 1.0)),
        # Zero is inside, wherever the one stop is.
        ((-9.0, math.inf), (-9.0, 3.0)),
    ],
)
def test_ends_that_are_missing(position: tuple[float, float] | None, found: object):
    z = np.array([0.0, 0.0, 1.0])
    joint = Joint("j", "revolute", 0, z, np.eye(3), np.zeros(3), position)
    assert joint.within(3.0) == found
