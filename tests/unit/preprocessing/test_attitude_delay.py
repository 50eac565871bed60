import numpy as np
import pytest
from random_motions import random_motion
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from orbident.preprocessing.delays import attitude_delay
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate

ROBOT = load_robot("paper-spatial")
FLIGHT = simulate(ROBOT, random_motion(ROBOT, duration=60.0), rate=50.0)
T, W = FLIGHT.t, FLIGHT.vector("gyro")
X = FLIGHT.vector("attitude", "xyzw")
BIAS = np.array([1e-4, -2e-4, 5e-5])


def late_fixes(late, std=0.0, every=1, seed=0):
    random = np.random.default_rng(seed)
    then = T - late
    x = CubicSpline(T, X)(np.clip(then, T[0], T[-1]))
    noise = Rotation.from_rotvec(std * random.standard_normal((T.size, 3)))
    fixes = (noise * Rotation.from_quat(x)).as_quat()
    fixes[(then < T[0]) | (then > T[-1])] = np.nan
    fixes[np.arange(T.size) % every > 0] = np.nan
    return fixes


@pytest.mark.parametrize("late", [0.037, -0.12, 0.5])
def test_the_delay_is_found_exactly_without_noise(late):
    found = attitude_delay(T, W + BIAS, late_fixes(late))
    assert found is not None
    # The spline of 50 Hz samples between them.
    assert found.late == pytest.approx(late, abs=1e-6)
    assert found.believed


@pytest.mark.slow
@pytest.mark.parametrize("gyro", [3e-6, 1e-4, 3e-4], ids="{:g} rad/sqrt(s)".format)
def test_with_noise_it_is_as_sure_as_it_says(gyro):
    errors = []
    for seed in range(20):
        random = np.random.default_rng(100 + seed)
        w = W + BIAS + random.normal(0.0, gyro / np.sqrt(0.02), W.shape)
        found = attitude_delay(T, w, late_fixes(0.037, 1e-4, 5, seed))
        assert found is not None
        assert found.believed == (abs(found.late) > 5 * found.std)
        errors.append((found.late - 0.037) / found.std)
    # Twenty squares: std 0.32; three of them.
    assert np.mean(np.square(errors)) == pytest.approx(1.0, abs=0.95)


def test_clocks_that_agree_are_left_alone():
    for seed in range(20):
        found = attitude_delay(T, W + BIAS, late_fixes(0.0, 1e-4, 5, seed))
        assert found is not None
        assert not found.believed


def test_a_gyro_that_is_turned_and_scaled_is_not_late():
    E = 1e-3 * np.array([[0.5, -1.0, 1.0], [1.0, 0.5, -1.0], [-1.0, 1.0, 0.5]])
    found = attitude_delay(T, W @ (np.eye(3) + E).T, late_fixes(0.005, 1e-4))
    assert found is not None
    # Without E among the unknowns: -5 ms.
    assert found.late == pytest.approx(0.005, abs=5 * found.std)
    assert found.std < 1e-3


def test_what_is_declared_is_not_found_again():
    found = attitude_delay(T, W + BIAS, late_fixes(0.037), declared=0.03)
    assert found is not None
    assert found.late == pytest.approx(0.007, abs=1e-6)
    known = attitude_delay(T, W + BIAS, late_fixes(0.037), declared=0.037)
    assert known is not None
    assert not known.believed


def test_a_base_that_does_not_turn_tells_nothing():
    found = attitude_delay(T, 0 * W, np.tile([0.0, 0.0, 0.0, 1.0], (T.size, 1)))
    assert found is not None
    assert not found.believed


def test_too_few_fixes_tell_nothing():
    assert attitude_delay(T, W, late_fixes(0.0, every=1000)) is None


@pytest.mark.parametrize("declared", [0.0, 1e3, -1e3])
def test_too_few_fixes_within_the_gyro_samples_tell_nothing(declared):
    """As where the robot file declares a latency that is longer than the recording."""
    few = late_fixes(0.0)
    if not declared:
        few[7:] = np.nan
        few[-9:] = late_fixes(0.0)[-9:]
    w = W.copy()
    w[: T.size // 2] = np.nan
    assert attitude_delay(T, w, few, declared) is None
