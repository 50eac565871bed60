import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from orbident.errors import InputError
from orbident.preprocessing.integrals import (
    bias_response,
    velocity_from_accelerometer,
    velocity_from_increments,
)
from orbident.robot.sensor_schema import AccelerometerSpec
from orbident.simulation.sensor import read_increments

T = np.linspace(0.0, 20.0, 401)
RATE = np.array([0.02, -0.05, 0.1])
R_WB = Rotation.from_rotvec(T[:, None] * RATE)
X_WB = R_WB.as_quat()
V = np.column_stack([np.sin(T), np.cos(0.7 * T), 0.1 * T])
A = np.column_stack([np.cos(T), -0.7 * np.sin(0.7 * T), np.full(T.size, 0.1)])
F = R_WB.inv().apply(A)


def increments():
    """Those of a sensor without errors."""
    exact, random = AccelerometerSpec(increments=True), np.random.default_rng(0)
    return read_increments(exact, np.hstack([X_WB, V]), 0.05, random)


def test_felt_force_gives_the_velocity_back():
    found = velocity_from_accelerometer(T, X_WB, F)
    # The spline's integral is off by h^4 f'''/ some hundred: 6e-6 / 384 at h = 0.05.
    np.testing.assert_allclose(found, V - V[0], rtol=0, atol=5e-8)


def test_missing_forces_are_bridged():
    gaps = F.copy()
    gaps[100:104] = gaps[::7] = np.nan
    gaps[0] = F[0]
    found = velocity_from_accelerometer(T, X_WB, gaps)
    # A gap of 0.25 s: (0.25 / 0.05)^4 of the error without gaps.
    np.testing.assert_allclose(found, V - V[0], rtol=0, atol=1e-5)


def test_forces_missing_at_the_ends_are_those_beside_them():
    gaps = F.copy()
    gaps[:2] = gaps[-3:] = np.nan
    found = velocity_from_accelerometer(T, X_WB, gaps)
    # The force changes by 1 m/s^3 at most, over 0.1 s and 0.15 s.
    np.testing.assert_allclose(found, V - V[0], rtol=0, atol=0.02)


def test_increments_are_exact():
    dv = increments()
    np.testing.assert_allclose(velocity_from_increments(X_WB, dv), V - V[0], atol=1e-13)


def test_after_a_missing_increment_nothing_is_known():
    dv = increments()
    dv[200] = np.nan
    found = velocity_from_increments(X_WB, dv)
    assert np.isfinite(found[:200]).all()
    assert np.isnan(found[200:]).all()


def test_a_bias_shows_as_its_response():
    b = np.array([1e-3, -2e-3, 5e-4])
    wrong = velocity_from_accelerometer(T, X_WB, F + b)
    right = velocity_from_accelerometer(T, X_WB, F)
    # Both are linear in the force: rounding only.
    np.testing.assert_allclose(wrong - right, bias_response(T, X_WB) @ b, atol=1e-13)


def test_too_few_forces_are_refused():
    f_S = np.full((T.size, 3), np.nan)
    f_S[:3] = 1.0
    with pytest.raises(
        InputError, match="accelerometer has 3 samples; give at least 4"
    ):
        velocity_from_accelerometer(T, X_WB, f_S)
