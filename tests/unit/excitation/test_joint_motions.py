from dataclasses import replace

import numpy as np
import pytest

from orbident.excitation.conditions import conditions_for
from orbident.excitation.joint_limits import joint_motions
from orbident.robot.joint_schema import coupled_joints
from orbident.robot.robot_file import load_robot
from orbident.trajectories.trajectory import Trajectory

DURATION, HARMONICS, NODES = 20.0, 3, 201
# Coefficients are up to 400 times the motion they make (the least singular value is
# 0.0026 of the greatest), and lose as much of the 16 digits.
ROUNDING = 1e-11


@pytest.fixture(scope="module")
def ends():
    random = np.random.default_rng(0)
    return 0.1 * random.standard_normal((2, 2, 3))


@pytest.fixture(scope="module")
def motions(ends):
    robot = load_robot("cepheus-like")
    given = conditions_for(robot, DURATION, HARMONICS)
    given = replace(given, start=ends[0], end=ends[1])
    return joint_motions(given, coupled_joints(robot), NODES)


def test_a_motion_is_its_coefficients(motions, ends):
    """Offset and basis add up to Eq. 41, as the trajectory file evaluates it."""
    y = np.random.default_rng(1).standard_normal((2, 2 * HARMONICS))
    a, b = motions.coefficients(y)
    trajectory = Trajectory(DURATION, ("joint1", "joint2"), a, b, ends[0], ends[1])
    for history, offset, basis in zip(
        trajectory.at(motions.t), motions.offset, motions.basis, strict=True
    ):
        ours = offset + basis @ (motions.scale[:, None] * y).T
        np.testing.assert_allclose(ours, history, rtol=0, atol=ROUNDING)


def test_the_ends_are_those_of_the_offset(motions):
    for basis in motions.basis:
        np.testing.assert_allclose(basis[[0, -1]], 0.0, atol=ROUNDING)


def test_coordinates_have_rates_of_unit_mean_square(motions):
    rates = motions.basis[1]
    np.testing.assert_allclose(
        rates.T @ rates / NODES, np.eye(2 * HARMONICS), rtol=0, atol=ROUNDING
    )


def test_the_same_motions_at_other_times(motions):
    coarse = motions.resampled(51)
    np.testing.assert_allclose(coarse.t, motions.t[::4], rtol=0, atol=ROUNDING)
    for fewer, all_of_them in zip(coarse.basis, motions.basis, strict=True):
        np.testing.assert_allclose(fewer, all_of_them[::4], rtol=0, atol=ROUNDING)


def test_gradients_are_those_of_the_motion(motions):
    """`<by, along(y)>` is linear in `y`: its gradient gives it back."""
    random = np.random.default_rng(3)
    y = random.standard_normal((2, 2 * HARMONICS))
    by = random.standard_normal((2, NODES, 2))
    moved = [
        history - offset
        for history, offset in zip(motions.along(y), motions.offset[:2], strict=True)
    ]
    expected = sum((b * x).sum() for b, x in zip(by, moved, strict=True))
    assert (motions.pull_back(*by) * y).sum() == pytest.approx(expected, rel=1e-11)
