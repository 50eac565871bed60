import numpy as np
import pytest
from random_motions import random_motion
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from orbident.errors import InputError
from orbident.robot.robot_file import load_robot
from orbident.sensing.simulate import simulate
from orbident.signals.gyro_integration import integrate_gyro

START = np.array([0.2, 0.1, 0.3, 0.93]) / np.linalg.norm([0.2, 0.1, 0.3, 0.93])


def rate(t):
    return np.array(
        [0.3 * np.sin(t), 0.2 * np.cos(0.7 * t), 0.1 + 0.1 * np.sin(0.4 * t)]
    )


def angle(x, y):
    return (Rotation.from_quat(x).inv() * Rotation.from_quat(y)).magnitude()


def by_scipy(t):
    def derivative(time, x):
        (v, s), w = (x[:3], x[3]), rate(time)
        return 0.5 * np.append(s * w + np.cross(v, w), -v @ w)

    solution = solve_ivp(
        derivative, (t[0], t[-1]), START, "DOP853", t, rtol=1e-12, atol=1e-14
    )
    return solution.y.T


def test_error_shrinks_with_the_fourth_power_of_the_step():
    errors = []
    for h in (0.2, 0.1, 0.05):
        t = np.arange(0.0, 20.0 + h / 2, h)
        found = integrate_gyro(t, rate(t).T, START)
        errors.append(angle(by_scipy(t), found).max())
    # 16 but for the spline's ends, where not-a-knot is of third order.
    assert errors[0] / errors[1] > 12
    assert errors[1] / errors[2] > 12
    assert errors[2] < 1e-7


def test_ideal_gyro_of_a_simulation_gives_its_attitude():
    robot = load_robot("paper-spatial")
    recording = simulate(robot, random_motion(robot), rate=20.0)
    x_WB = recording.vector("attitude", "xyzw")
    found = integrate_gyro(recording.t, recording.vector("gyro"), x_WB[0])
    # Rates change within seconds: (0.05 s)^4 of their fourth derivatives.
    assert angle(found, x_WB).max() < 1e-7


def test_longer_than_a_batch():
    t = np.arange(0.0, 60.0, 0.01)
    found = integrate_gyro(t, np.tile([0.0, 0.0, 0.05], (t.size, 1)), START)
    turned = Rotation.from_rotvec(0.05 * t[:, None] * [0, 0, 1])
    expected = Rotation.from_quat(START) * turned
    # Rounding of 6000 products.
    assert angle(found, expected.as_quat()).max() < 1e-11


def test_gaps_are_bridged_and_ends_are_not():
    t = np.arange(0.0, 10.0, 0.05)
    w = rate(t).T.copy()
    w[50:53] = w[:3] = w[-2:] = np.nan
    truth = by_scipy(t)
    found = integrate_gyro(t, w, truth[3])
    assert np.isnan(found[:3]).all()
    assert np.isnan(found[-2:]).all()
    # A gap of 0.2 s in rates with a period of 6 s.
    assert angle(found[3:-2], truth[3:-2]).max() < 1e-6


def test_too_few_samples_are_refused():
    with pytest.raises(InputError, match="gyro has 3 samples; give at least 4"):
        integrate_gyro(np.arange(3.0), np.zeros((3, 3)), START)
