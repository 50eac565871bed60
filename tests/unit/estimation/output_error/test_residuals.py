"""What residuals say of the noise, on noise whose size is known.

How many unknowns samples tell is what the logarithm of the information's determinant
grows by, in closed form, as their weights do: `d ln|I| / d ln w^2 = tr(I^-1 w^2 A'A)`.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter
from small_problems import (
    Small,
    small_problem,
    small_recording_in_space,
    small_robot_in_space,
)

from orbident.estimation.output_error.looseness import TURN_AND_BIASES
from orbident.estimation.output_error.noise_scaling import (
    HUBER,
    LEAST,
    Whitened,
    _unknowns,
    change,
    reweighted,
    robust,
    whitened,
)
from orbident.estimation.output_error.problem import linear
from orbident.estimation.output_error.solver import solution_at
from orbident.estimation.solution import BySensor
from orbident.recordings.recording import Recording
from orbident.robot.sensor_schema import declared_sensors

SAMPLES = 20000


def noise(seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).standard_normal((SAMPLES, 3))


def test_scale_of_white_noise():
    # 60000 numbers: the std of their std is 1 / sqrt(2 n) = 0.3 %.
    assert Whitened(2.5 * noise(), 0.0).scale == pytest.approx(2.5, rel=0.01)


def test_scale_counts_the_unknowns():
    """Noise of 10 samples, 6 of which were used up."""
    values = np.array([[1.0, -1.0]] * 5)
    assert Whitened(values, 6.0).scale == pytest.approx(np.sqrt(10 / 4))


def test_scale_leaves_outliers_out():
    values = noise()
    values[::20] = 1000.0
    # The 5 % of outliers widen the median's bound a little.
    assert Whitened(values, 0.0).scale == pytest.approx(1.0, rel=0.01)


def test_scale_is_never_zero():
    assert Whitened(np.zeros((10, 3)), 0.0).scale == LEAST
    assert Whitened(np.zeros((0, 3)), 0.0).scale == 1.0


def test_whiteness_of_white_and_of_coloured_noise():
    # Std of the correlation of 20000 x 3 pairs: 0.004.
    assert abs(Whitened(noise(), 0.0).whiteness) < 0.02
    for a in (0.5, -0.3):
        coloured = np.asarray(lfilter([1.0], [1.0, -a], noise(), axis=0))
        assert Whitened(coloured, 0.0).whiteness == pytest.approx(a, abs=0.02)
    assert Whitened(np.zeros((10, 3)), 0.0).whiteness == 0.0


def test_rows_without_a_sample_and_axes_that_do_not_count_are_left_out():
    weights = np.ones((8, 3))
    weights[[1, 7]] = 0.0
    weights[:, 2] = 0.0
    found = whitened(weights, np.arange(24.0).reshape(8, 3), 5.0)
    expected = [[0, 1], [6, 7], [9, 10], [12, 13], [15, 16], [18, 19]]
    np.testing.assert_array_equal(found.values, expected)
    assert found.unknowns == 5.0


def test_hubers_weights():
    """The sum of squares grows linearly beyond the threshold: `HUBER |r|`."""
    old = np.ones((3, 1))
    residuals = np.array([[0.5], [-HUBER], [-100.0]])
    again = reweighted(residuals, old, robust(old, residuals)).ravel()
    np.testing.assert_allclose(again**2, [0.25, HUBER**2, HUBER * 100.0])


def test_what_does_not_count_weighs_nothing():
    """A late clock may turn an attitude that was never seen by more than there is."""
    weights, residuals = np.array([[2.0], [0.0]]), np.array([[1.0], [np.nan]])
    np.testing.assert_array_equal(robust(weights, residuals), weights)


def test_weights_of_less_noise():
    random = np.random.default_rng(0)
    old = np.where(random.random((10, 3)) < 0.3, 0.0, 2.0)
    residuals = old * random.standard_normal((10, 3))
    np.testing.assert_allclose(reweighted(residuals, old, old / 4), residuals / 4)
    assert change(old, old) == 0.0
    assert change(old, old / 4) == pytest.approx(0.75)
    assert change(np.zeros((1, 1)), np.zeros((1, 1))) == 0.0


def with_encoders(gyro: float) -> Small:
    """A recording in space: noise of encoders 0.1 mrad, that of the gyro in rad/s."""
    robot, random = small_robot_in_space(), np.random.default_rng(0)
    flown = small_recording_in_space(robot)
    dt = float(np.median(np.diff(flown.t)))
    noise = {
        "gyro": {"angle_random_walk": gyro * dt**0.5},
        "joints": {"position": 1e-4},
    }
    robot = replace(robot, sensors=declared_sensors({"rate": 1 / dt, **noise}))
    std = {"gyro": gyro, "joint": 1e-4, "position": 1e-3, "velocity": 1e-3}
    columns = {
        name: x + std.get(name.partition(".")[0], 0.0) * random.standard_normal(x.size)
        for name, x in flown.columns.items()
        if not (name.startswith("joint.") and name.endswith("velocity"))
    }
    return small_problem(robot, Recording(flown.t, columns))


def information(small: Small, weights: BySensor) -> float:
    """The logarithm of its determinant."""
    problem, prior, state, _ = small
    here = linear(problem, weights, state)
    own = slice(None, here.local)
    eliminated = np.diagonal(here.links[:, own, own], axis1=1, axis2=2)
    common = prior.added(here.common, state)[:-1, :-1]
    parts = eliminated.ravel(), np.diag(here.factor)[own], np.diag(common)
    return 2 * float(np.sum(np.log(np.abs(np.concatenate(parts)))))


@pytest.mark.parametrize("gyro", [1e-5, 1e-3, 1e-1])
def test_encoders_tell_what_the_base_does_not(gyro):
    """A twentieth of what they tell where the gyro knows less."""
    small, step = with_encoders(gyro), 0.01
    problem, prior, state, _ = small
    here = linear(problem, problem.weights, state)
    solution = solution_at(state, here, prior, problem.weights, True, here.cost)
    less, more = (
        information(
            small, {**problem.weights, "joints": by * problem.weights["joints"]}
        )
        for by in np.exp([-step / 2, step / 2])
    )
    exact = (more - less) / (2 * step)
    # One boundary stands for all, and the ends of a recording are not as its middle.
    assert _unknowns(problem, solution)["joints"] == pytest.approx(exact, rel=0.15)


def test_what_is_known_beforehand_makes_no_residual_small():
    """Unknowns of a recording that are held make no residual smaller."""
    problem, prior, state, _ = with_encoders(1e-3)
    here = linear(problem, problem.weights, state)
    told = []
    for std in (prior.std, 1e-12 * prior.std):
        held = prior._replace(std=std)
        solution = solution_at(state, here, held, problem.weights, True, here.cost)
        found = _unknowns(problem, solution)
        del found["joints"]
        told.append(sum(found.values()) - TURN_AND_BIASES)
    # All but the momentum, which is known to be zero; and then nothing.
    np.testing.assert_allclose(told, [state.common.size - 3, 0.0], atol=0.1)
