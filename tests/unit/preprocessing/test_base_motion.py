import numpy as np
import pytest
from random_motions import random_motion
from scipy.spatial.transform import Rotation

from orbident.errors import InputError
from orbident.preprocessing.base_motion import attitude_rates, same_sign
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate

ROBOT = load_robot("paper-spatial")
FLIGHT = simulate(ROBOT, random_motion(ROBOT), rate=50.0)
T, W = FLIGHT.t, FLIGHT.vector("gyro")
X = FLIGHT.vector("attitude", "xyzw")
STD = 3e-4


def noisy(seed):
    random = np.random.default_rng(seed)
    turn = Rotation.from_rotvec(STD * random.standard_normal((T.size, 3)))
    fixes = (Rotation.from_quat(X) * turn).as_quat()
    return fixes * random.choice([-1, 1], (T.size, 1))


def test_exact_attitudes_give_the_rate():
    _, w = attitude_rates(T, X)
    # The spline's ends, where it knows one side only.
    np.testing.assert_allclose(w, W, rtol=0, atol=1e-6)


def test_noisy_attitudes_of_either_sign():
    x, w = attitude_rates(T, noisy(0))
    error = (Rotation.from_quat(x).inv() * Rotation.from_quat(X)).magnitude()
    # Smoothing over about a second of 50 Hz samples; raw differences have 2e-2 rad/s.
    assert np.sqrt(np.mean(error**2)) < 0.5 * STD
    assert np.sqrt(np.mean((w - W) ** 2)) < 1e-3


def test_rows_without_a_fix_have_no_rate():
    fixes = noisy(1)
    fixes[100:110, 2] = np.nan
    x, w = attitude_rates(T, fixes)
    missing = np.isin(np.arange(T.size), np.arange(100, 110))
    np.testing.assert_array_equal(np.isnan(w).all(axis=1), missing)
    np.testing.assert_array_equal(np.isnan(x).all(axis=1), missing)


def test_same_sign_skips_gaps():
    fixes = X.copy()
    fixes[5:] *= -1
    fixes[4] = np.nan
    turned = same_sign(fixes)
    np.testing.assert_array_equal(turned[5:], X[5:])
    assert np.isnan(turned[4]).all()


def test_too_few_fixes_are_refused():
    fixes = np.full(X.shape, np.nan)
    fixes[:3] = X[:3]
    with pytest.raises(InputError, match=r"flight: attitude.* has 3 samples"):
        attitude_rates(T, fixes, "flight")
