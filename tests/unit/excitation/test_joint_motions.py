import numpy as np
import pytest

from orbident.excitation.joint_motions import joint_motions
from orbident.excitation.limits import limits_of
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
    limits = limits_of(load_robot("cepheus-like"))
    return joint_motions(ends[0], ends[1], DURATION, HARMONICS, limits, NODES)


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


def test_coordinates_come_back(motions):
    y = np.random.default_rng(2).standard_normal((2, 2 * HARMONICS))
    back = motions.coordinates(*motions.coefficients(y))
    np.testing.assert_allclose(back, y, rtol=0, atol=ROUNDING)


def test_every_so_many_nodes(motions):
    coarse = motions.every(4)
    assert coarse.t.size == 51
    np.testing.assert_array_equal(coarse.basis[0], motions.basis[0][::4])
