import pickle

import numpy as np

from orbident.robot.description import Robot


def test_a_robot_made_by_hand_can_be_sent_to_another_process():
    made = Robot("r", "spatial", ("base",), (), np.ones((1, 10)), np.zeros(3))
    found = pickle.loads(pickle.dumps(made))
    assert (found.structure, found.sensors, found.document) == ({}, {}, {})
