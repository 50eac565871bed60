"""What the core makes of gyro and fixes, against slow and obvious arithmetic."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from reference.gauss_markov import GaussMarkov
from scipy.spatial.transform import Rotation

from orbident import _core

pytestmark = pytest.mark.core

SEEDS = st.integers(0, 2**32 - 1)


@given(seed=SEEDS, rows=st.integers(2, 12), power=st.floats(-4.0, -1.0))
def test_gyro_errors_equal_the_dense_smoother(seed, rows, power):
    random = np.random.default_rng(seed)
    h = random.uniform(0.05, 2.0, rows - 1)
    B = h[:, None, None] * Rotation.random(rows - 1, rng=random).as_matrix()
    N, drift, std = 10.0**power, 10.0 ** (power - 1), 0.01
    before = np.array([1.0, 0.1])
    y = 0.1 * random.standard_normal((rows, 3))
    y[random.random(rows) < 0.5] = np.nan
    mean, variance = _core.smooth_gyro_error(B, h, y, np.array([N, drift, std]), before)
    F = np.tile(np.eye(6), (rows - 1, 1, 1))
    F[:, :3, 3:] = -B
    Q = [np.diag(np.repeat([N**2 * dt, drift**2 * dt], 3)) for dt in h]
    dense = GaussMarkov(F, Q, np.eye(3, 6), y, std**2, np.diag(np.repeat(before**2, 3)))
    # Covariances from 1 to 1e-10 are added and subtracted; rounding is 1e-16 of 1.
    np.testing.assert_allclose(mean, dense.mean, atol=1e-8)
    expected = np.diagonal(dense.covariance, axis1=1, axis2=2)
    np.testing.assert_allclose(variance, expected, rtol=1e-6)


@given(seed=SEEDS, rows=st.integers(0, 20), size=st.sampled_from([0.0, 1e-9, 0.1, 3]))
def test_integration_is_a_product_of_rotations(seed, rows, size):
    random = np.random.default_rng(seed)
    h = random.uniform(0.0, 1.0, rows)
    w_1, w_2 = size * random.standard_normal((2, rows, 3))
    x = random.standard_normal(4)
    x /= np.linalg.norm(x)
    found = _core.integrate_rate(x, h, w_1, w_2)
    expected = [Rotation.from_quat(x)]
    for dt, one, two in zip(h, w_1, w_2, strict=True):
        step = dt / 2 * (one + two) + np.sqrt(3) / 12 * dt**2 * np.cross(one, two)
        expected.append(expected[-1] * Rotation.from_rotvec(step))
    for attitude, matrix in zip(found, expected, strict=True):
        np.testing.assert_allclose(
            Rotation.from_quat(attitude).as_matrix(), matrix.as_matrix(), atol=1e-14
        )
    # Rounding of 20 products.
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1.0, rtol=1e-14)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"B": np.ones((4, 3, 3))}, r"B has the shape \(4, 3, 3\); give \(3, 3, 3\)"),
        ({"h": np.ones(4)}, r"h has the shape \(4,\); give \(3,\)"),
        ({"noise": np.ones(2)}, r"noise has the shape \(2,\); give \(3,\)"),
        ({"y": np.ones((0, 3))}, "y has no rows; give at least one"),
    ],
)
def test_wrong_arrays_are_named(changed, message):
    arrays = {
        "B": np.ones((3, 3, 3)),
        "h": np.ones(3),
        "y": np.ones((4, 3)),
        "noise": np.ones(3),
        "before": np.ones(2),
    }
    with pytest.raises(ValueError, match=message):
        _core.smooth_gyro_error(**(arrays | changed))
