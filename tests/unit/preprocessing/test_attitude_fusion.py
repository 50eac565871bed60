import numpy as np
import pytest
from random_motions import random_motion
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from orbident.errors import InputError
from orbident.preprocessing.integrals import (
    GyroNoise,
    fuse_attitude,
    integrate_gyro,
)
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate

START = np.array([0.2, 0.1, 0.3, 0.93]) / np.linalg.norm([0.2, 0.1, 0.3, 0.93])

N, STD = 1e-3, 5e-3
BIAS = np.array([2e-3, -1e-3, 5e-4])
MOTION = simulate(
    load_robot("paper-spatial"),
    random_motion(load_robot("paper-spatial"), duration=60.0),
    rate=20.0,
)
T, W = MOTION.t, MOTION.vector("gyro")
X = MOTION.vector("attitude", "xyzw")


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


def test_integration_error_shrinks_with_the_fourth_power_of_the_step():
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


def test_a_long_integration():
    t = np.arange(0.0, 60.0, 0.01)
    found = integrate_gyro(t, np.tile([0.0, 0.0, 0.05], (t.size, 1)), START)
    turned = Rotation.from_rotvec(0.05 * t[:, None] * [0, 0, 1])
    expected = Rotation.from_quat(START) * turned
    # Rounding of 6000 products.
    assert angle(found, expected.as_quat()).max() < 1e-11


def test_gaps_of_the_gyro_are_bridged_and_ends_are_not():
    t = np.arange(0.0, 10.0, 0.05)
    w = rate(t).T.copy()
    w[50:53] = w[:3] = w[-2:] = np.nan
    truth = by_scipy(t)
    found = integrate_gyro(t, w, truth[3])
    assert np.isnan(found[:3]).all()
    assert np.isnan(found[-2:]).all()
    # A gap of 0.2 s in rates with a period of 6 s.
    assert angle(found[3:-2], truth[3:-2]).max() < 1e-6


def test_too_few_gyro_samples_are_refused():
    with pytest.raises(InputError, match="gyro has 3 samples; give at least 4"):
        integrate_gyro(np.arange(3.0), np.zeros((3, 3)), START)


def measured(seed, every=10, bias=BIAS):
    random = np.random.default_rng(seed)
    w = W + bias + random.normal(0.0, N / np.sqrt(0.05), W.shape)
    fixes = np.full(X.shape, np.nan)
    noise = Rotation.from_rotvec(STD * random.standard_normal((T.size, 3)))
    fixes[::every] = (noise * Rotation.from_quat(X)).as_quat()[::every]
    return w, fixes


def error(x):
    return (Rotation.from_quat(x) * Rotation.from_quat(X).inv()).as_rotvec()


def test_errors_are_as_large_as_they_say():
    squares, biases = [], []
    for seed in range(20):
        w, fixes = measured(seed)
        fused = fuse_attitude(T, w, fixes, GyroNoise(N), STD)
        squares.append((error(fused.x_WB) / fused.std) ** 2)
        biases.append(((fused.bias - BIAS) / fused.bias_std)[0] ** 2)
    # The error of a row is like that of its neighbours over some fixes: about 20 x 3 x
    # 30 independent squares of mean 1, std 1.41/sqrt(1800) = 0.033. Three times that.
    assert np.mean(squares) == pytest.approx(1.0, abs=0.1)
    # 60 squares: std 0.18.
    assert np.mean(biases) == pytest.approx(1.0, abs=0.54)


def test_it_is_better_than_fixes_and_than_the_gyro_alone():
    w, fixes = measured(1)
    fused = fuse_attitude(T, w, fixes, GyroNoise(N), STD)
    rms = np.sqrt(np.mean(error(fused.x_WB) ** 2))
    # The balance of N sqrt(dt) a step against STD a fix every 0.5 s.
    assert rms < 0.4 * STD
    assert rms == pytest.approx(np.sqrt(np.mean(fused.std**2)), rel=0.5)


def test_against_dense_least_squares():
    """For a base at rest the equations are linear: solve them all at once."""
    n, h = 60, 0.1
    t, random = np.arange(n) * h, np.random.default_rng(4)
    w = 2e-3 + 1e-3 * random.standard_normal((n, 3))
    phi = 1e-3 * random.standard_normal((n, 3))
    seen = random.random(n) < 0.3
    seen[0] = True
    fixes = np.where(seen[:, None], Rotation.from_rotvec(phi).as_quat(), np.nan)
    fused = fuse_attitude(t, w, fixes, GyroNoise(1e-3), 1e-3)
    # Unknowns: the angle at every row, and the bias; the gyro's own integral is by its
    # spline, which the trapezoid equals to 1e-5 rad here.
    turned = CubicSpline(t, w).antiderivative()
    for axis in range(3):
        A, b = [], []
        for k in range(n - 1):
            row = np.zeros(n + 1)
            row[k + 1], row[k], row[n] = 1.0, -1.0, h
            weight = 1 / (1e-3 * np.sqrt(h))
            A.append(row * weight)
            b.append(weight * (turned(t[k + 1])[axis] - turned(t[k])[axis]))
        for k in np.flatnonzero(seen):
            A.append(np.eye(n + 1)[k] / 1e-3)
            b.append(phi[k, axis] / 1e-3)
        x = np.linalg.lstsq(np.array(A), np.array(b), rcond=None)[0]
        covariance = np.linalg.inv(np.array(A).T @ np.array(A))
        angle = Rotation.from_quat(fused.x_WB).as_rotvec()[:, axis]
        # Turns of 1e-3 rad do not commute at 1e-6.
        np.testing.assert_allclose(angle, x[:n], atol=1e-5)
        np.testing.assert_allclose(fused.bias[:, axis], x[n], atol=1e-5)
        expected = np.sqrt(np.diag(covariance))
        np.testing.assert_allclose(fused.std[:, axis], expected[:n], rtol=1e-3)
        np.testing.assert_allclose(fused.bias_std[:, axis], expected[n], rtol=1e-3)


def test_a_large_bias_and_few_fixes():
    w, fixes = measured(2, every=200, bias=20 * BIAS)
    fused = fuse_attitude(T, w, fixes, GyroNoise(N), STD)
    # 40 mrad/s over 60 s are more than a radian: the second round finds it.
    np.testing.assert_allclose(fused.bias[0], 20 * BIAS, atol=5 * fused.bias_std.max())
    last = np.flatnonzero(np.isfinite(fixes[:, 0]))[-1]
    assert np.abs(error(fused.x_WB)[:last]).max() < 5 * fused.std[:last].max()


def test_rows_without_gyro_or_before_it():
    w, fixes = measured(3)
    w[:5] = w[300:320] = np.nan
    fused = fuse_attitude(T, w, fixes, GyroNoise(N), STD)
    assert np.isnan(fused.x_WB[:5]).all()
    assert np.isfinite(fused.x_WB[5:]).all()


@pytest.mark.parametrize(
    ("w", "fixes", "message"),
    [
        (np.full(W.shape, np.nan), X, "gyro has no samples"),
        (W, np.full(X.shape, np.nan), "attitude has no samples while the gyro has"),
    ],
)
def test_one_of_the_two_missing_is_refused(w, fixes, message):
    with pytest.raises(InputError, match=message):
        fuse_attitude(T, w, fixes, GyroNoise(N), STD)
