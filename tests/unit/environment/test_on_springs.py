"""What swings inside a robot: its column where all derivatives are known."""

import numpy as np
from scipy.spatial.transform import Rotation

from orbident.environment.motion import RobotMotion
from orbident.environment.torques_and_forces import OnSprings
from orbident.recordings.derivatives import HALF, derivatives
from orbident.robot.robot_file import load_robot


def test_the_torque_of_a_turn_about_one_axis():
    """About a fixed axis the momentum `K d2w/dt2` has the torque `K d3w/dt3`."""
    robot, t, p = load_robot("paper-spatial"), np.linspace(0, 20, 801), 1.5
    w = np.zeros((t.size, 3))
    w[:, 2] = 0.02 * np.sin(p * t)
    angle = 0.02 / p * (1 - np.cos(p * t))
    R_WB = Rotation.from_rotvec(angle[:, None] * np.eye(3)[2]).as_matrix()
    still = np.zeros((t.size, len(robot.joints)))
    motion = RobotMotion(robot, t, still, still, R_WB, w, None)
    columns = {each.name: each for each in OnSprings().columns(motion)}
    assert len(columns) == 6
    torque = columns["on_springs.zz"].effect.torque[:, 1]
    middles = t[1::2]
    inside = (middles > 1) & (middles < 19)
    np.testing.assert_allclose(
        torque[inside, 2], (-0.02 * p**3 * np.cos(p * middles))[inside], atol=1e-3
    )
    assert np.abs(torque[:, :2]).max() < 1e-12


def test_the_noise_of_a_row_is_not_in_its_own_derivative():
    x = np.zeros((60, 1))
    x[30] = 1.0
    _, bent = derivatives(0.05 * np.arange(60.0), x)
    assert bent[30] == 0
    assert (bent[30 - HALF : 30] != 0).all()
