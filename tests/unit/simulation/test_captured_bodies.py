"""A change of inertia on the way, against conservation and the motion without one."""

from dataclasses import replace

import numpy as np
import pytest
from captured_bodies import (
    CapturedBody,
    holding,
    simulate_change,
    truth_through_change,
)
from random_motions import random_motion

from orbident.errors import InputError
from orbident.robot.parameters import inertia_about_com
from orbident.robot.robot_file import load_robot
from orbident.simulation.free_floating import BaseState, free_floating
from orbident.simulation.measure import truth_of
from orbident.simulation.simulate import float_along, sample_times

TARGET = CapturedBody(50.0, np.array([1.0, 0.2, -0.3]), np.diag([3.0, 4.0, 5.0]))
T = sample_times(10.0, 20.0)


def test_masses_and_moments_add_up():
    robot = load_robot("paper-spatial")
    after = holding(robot, TARGET)
    m_0, m_1 = robot.theta[-1, 0], after.theta[-1, 0]
    assert m_1 == m_0 + 50.0
    c_0 = robot.theta[-1, 1:4] / m_0
    com = (m_0 * c_0 + 50.0 * TARGET.com) / m_1
    np.testing.assert_allclose(after.theta[-1, 1:4] / m_1, com, rtol=1e-14)
    # Huygens-Steiner with the reduced mass.
    d = TARGET.com - c_0
    apart = m_0 * 50.0 / m_1 * (d @ d * np.eye(3) - np.outer(d, d))
    expected = inertia_about_com(robot.theta[-1]) + TARGET.I_com + apart
    np.testing.assert_allclose(
        inertia_about_com(after.theta[-1]), expected, atol=1e-12 * expected.max()
    )


def test_a_release_undoes_a_capture():
    robot = load_robot("paper-spatial")
    gone = CapturedBody(-50.0, TARGET.com, -TARGET.I_com)
    back = holding(holding(robot, TARGET), gone)
    np.testing.assert_allclose(back.theta, robot.theta, atol=1e-11)


@pytest.mark.parametrize("name", ["paper-spatial", "cepheus-like"])
def test_no_change_is_the_same_motion(name: str):
    robot = load_robot(name)
    motion = random_motion(robot, duration=10.0)
    true = truth_of(robot, float_along(robot, motion, 20.0), motion)
    found = truth_through_change(robot, robot, motion, 5.0, T)
    for key, expected in true._asdict().items():
        # Two attitude integrations to 1e-9 each, over levers of metres.
        np.testing.assert_allclose(getattr(found, key), expected, atol=1e-7)


def test_nothing_jumps_and_momentum_is_kept():
    robot = load_robot("paper-spatial")
    after = holding(robot, TARGET)
    motion = random_motion(robot, duration=10.0)
    true = truth_through_change(robot, after, motion, 4.975, T)
    for signal in (true.gyro, true.velocity, true.attitude, true.qd_rw, true.position):
        steps = np.abs(np.diff(signal, axis=0)).max(axis=1)
        assert steps[99] < 2 * np.median(steps) + 1e-12
    # From any later sample on, the heavier robot floats on by itself.
    late = T[120:]
    start = BaseState(
        true.gyro[120], true.attitude[120], true.velocity[120], true.qd_rw[120]
    )
    goes_on = free_floating(after, motion, late, start)
    np.testing.assert_allclose(true.gyro[120:], goes_on.w, atol=1e-8)
    assert not np.allclose(
        goes_on.w, float_along(robot, motion, 20.0).w[120:], atol=1e-5
    )


def test_bad_input():
    robot = load_robot("paper-spatial")
    with pytest.raises(InputError, match="no body 'hand'"):
        holding(robot, TARGET, "hand")
    motion = random_motion(robot, duration=10.0)
    for at in (0.0, 10.0, np.nan):
        with pytest.raises(InputError, match="change at"):
            simulate_change(robot, replace(robot), motion, at)
