"""Deviations of every method grow with the noise, and errors are within them."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from edited_recordings import changed
from scipy.spatial.transform import Rotation
from truth import truth

from orbident.estimation.identify import Method, estimator_of, identify
from orbident.estimation.momentum_problem import momentum_problem
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.sensor_schema import SensorsSpec

slow = partial(pytest.param, marks=pytest.mark.slow)


@pytest.mark.parametrize(
    "method",
    ["least-squares", *map(slow, ("maximum-likelihood", "structured", "recursive"))],
)
def test_noise_shows_in_the_deviations(
    method: Method, robot: Robot, recording: Recording
):
    """Ten times the noise gives ten times the deviations; small noise, small errors.

    Noise of what each method takes for noisy: the right-hand sides of the linear
    equations; all sensors of the base; gyro and velocity. None of it is declared. The
    deviations are the method's own; `identify` adds what all sensors show.
    """
    robot = replace(robot, sensors=SensorsSpec())
    estimator = estimator_of(method)
    noisy = ("velocity", "wheel" if method == "least-squares" else "gyro", "position")
    random = np.random.default_rng(0)
    draws = {
        name: random.standard_normal(recording.t.size)
        for name in recording.columns
        if name.startswith(noisy)
    }
    estimates, results = [], []
    for level in (1e-6, 1e-5):
        columns = {
            name: recording.columns[name] + level * draw for name, draw in draws.items()
        }
        columns |= attitude_with_noise(
            recording, level if method == "maximum-likelihood" else 0.0
        )
        spoiled = changed(recording, columns)
        problem = momentum_problem(robot, spoiled, "unknown", lambda _: None)
        estimates.append(estimator.estimate(problem, lambda _: None))
        results.append(identify(robot, spoiled, method))
    for name in ("pi", "phi", "base"):
        small, large = (getattr(estimate.parameters, name) for estimate in estimates)
        # A search ends within a hundredth of a deviation, weights within 5 %.
        part = 1e-3 if method == "least-squares" else 0.02
        one, ten = (np.sqrt(np.diag(each.covariance)) for each in (small, large))
        np.testing.assert_allclose(ten, 10 * one, rtol=part)
        error = small.values - truth(robot)[name]
        # Of some 20 standard normal numbers the largest is hardly ever beyond 4.
        assert np.abs(error / one).max() < 4.5
        for result in results:
            found = getattr(result, name)
            assert np.abs((found.values - truth(robot)[name]) / found.std).max() < 4.5
    for each in (estimates[0], *results):
        assert abs(each.mass.value - robot.mass) < 4.5 * each.mass.std


def attitude_with_noise(recording: Recording, std: float) -> dict[str, np.ndarray]:
    """Small random rotations, rad."""
    x = Rotation.from_quat(recording.vector("attitude", "xyzw"))
    draw = np.random.default_rng(1).standard_normal((recording.t.size, 3))
    turned = (x * Rotation.from_rotvec(std * draw)).as_quat()
    return {f"attitude.{k}": turned[:, i].copy() for i, k in enumerate("xyzw")}
