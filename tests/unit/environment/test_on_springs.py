"""What swings inside a robot: its column where all derivatives are known."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from orbident.environment.motion import RobotMotion
from orbident.environment.torques_and_forces import OnSprings
from orbident.recordings.derivatives import HALF, derivatives, second_derivative
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


def slow_and_noisy(std: float, seed: int = 0) -> tuple[np.ndarray, ...]:
    """A minute at 20 Hz of something slow, its second derivative, and samples of it."""
    t, p = np.arange(0.0, 60.0, 0.05), np.array([0.7, 1.0, 1.3])
    x = 0.03 * np.sin(p * t[:, None])
    noise = np.random.default_rng(seed).normal(0.0, std, x.shape)
    return t, -(p**2) * x, x + noise


def test_the_second_derivative_of_noisy_samples_is_of_the_motion():
    """With the noise of neighbours in it, a column seems to explain their noise.

    Of an arm of six joints, whose encoders took up some of a gyro's noise, something
    on a spring was seen in six good recordings of seven.
    """
    t, true, shown = slow_and_noisy(2e-4)
    _, narrow = derivatives(t, shown)
    inside = slice(40, -40)
    wide = second_derivative(t, shown)
    off, before = (np.std((x - true)[inside], axis=0) for x in (wide, narrow))
    assert (off < before / 4).all()


def test_without_noise_nothing_is_wider_than_the_motion_lets():
    t, true, shown = slow_and_noisy(0.0)
    error = (second_derivative(t, shown) - true)[40:-40]
    # A polynomial of fourth degree over 0.8 s.
    assert np.abs(error).max() < 1e-3 * np.abs(true).max()


def test_an_axis_that_moves_fast_leaves_those_that_move_slowly_as_they_are():
    """With a common width, an axis that hardly moved had its noise as the column."""
    t, _, shown = slow_and_noisy(2e-4)
    fast = 0.03 * np.sin(9.0 * t)
    beside = np.column_stack([fast, shown[:, 0]])
    alone = second_derivative(t, shown[:, :1])
    assert second_derivative(t, beside)[:, 1:] == pytest.approx(alone, rel=1e-12)
