"""Rotations against scipy's, and where formulas lose digits."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from orbident.model.rotations import (
    axis_rotation,
    cross_matrix,
    quaternion_matrix,
    quaternion_rate,
    rotate,
    rotate_back,
    rotation_angle,
)

RANDOM = np.random.default_rng(0)
SEVERAL = Rotation.random(20, rng=RANDOM)
X, R = SEVERAL.as_quat(), SEVERAL.as_matrix()
U, V = RANDOM.standard_normal((2, 20, 3))
# A dozen float64 operations on numbers of the order of 1.
ROUNDING = 1e-14


def test_cross_matrix():
    expected = np.cross(U, V)
    np.testing.assert_allclose(cross_matrix(U) @ V[..., None], expected[..., None])


def test_one_vector_against_many():
    """A single vector is turned by each of many."""
    turned = np.einsum("nij,j->ni", R, U[0])
    np.testing.assert_allclose(rotate(R, U[0]), turned, atol=ROUNDING)
    back = np.einsum("nji,j->ni", R, U[0])
    np.testing.assert_allclose(rotate_back(R, U[0]), back, atol=ROUNDING)


def test_products_of_stacks():
    np.testing.assert_allclose(rotate(R, V), SEVERAL.apply(V), atol=ROUNDING)
    back = SEVERAL.apply(V, inverse=True)
    np.testing.assert_allclose(rotate_back(R, V), back, atol=ROUNDING)


def test_axis_rotation():
    axes = U / np.linalg.norm(U, axis=-1, keepdims=True)
    angles = np.linspace(-7.0, 7.0, 20)
    expected = Rotation.from_rotvec(axes * angles[:, None]).as_matrix()
    found = axis_rotation(axes, angles)
    np.testing.assert_allclose(found, expected, atol=ROUNDING)


def test_quaternions_are_scalar_last_hamilton():
    np.testing.assert_allclose(quaternion_matrix(X), R, atol=ROUNDING)
    quarter = np.array([0.0, 0.0, 1.0, 1.0])
    turned = quaternion_matrix(quarter) @ np.array([1.0, 0.0, 0.0])
    np.testing.assert_allclose(turned, [0.0, 1.0, 0.0], atol=ROUNDING)


@pytest.mark.parametrize("norm", [1e-3, 1.0024, 50.0])
def test_norm_of_a_quaternion_does_not_matter(norm):
    np.testing.assert_allclose(quaternion_matrix(norm * X), R, atol=ROUNDING)


def test_quaternion_rate_turns_the_matrix():
    """`R_dot = R [w]x`, by central differences along the rate."""
    rate, step = quaternion_rate(X, U), 1e-5
    ahead, behind = (quaternion_matrix(X + sign * step * rate) for sign in (1, -1))
    expected = R @ cross_matrix(U)
    # Differences of second order: 1e-10, and rounding of 1e-16 / 1e-5.
    np.testing.assert_allclose((ahead - behind) / (2 * step), expected, atol=1e-8)


@pytest.mark.parametrize("angle", [0.0, 1e-15, 1e-9, 1e-4, 1.0, 3.0, np.pi])
def test_rotation_angle_of_small_and_large_angles(angle):
    """The cosine alone would lose angles below 1e-8."""
    turned = SEVERAL * Rotation.from_rotvec([0.6 * angle, 0.0, 0.8 * angle])
    found = rotation_angle(X, turned.as_quat())
    # Rounding of the quaternions themselves.
    np.testing.assert_allclose(found, angle, rtol=1e-13, atol=1e-15)


def test_rotation_angle_of_opposite_quaternions_is_zero():
    np.testing.assert_allclose(rotation_angle(X, -3.0 * X), 0.0, atol=1e-15)
