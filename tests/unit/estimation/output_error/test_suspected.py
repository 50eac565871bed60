"""Deviations hold that what is too faint to be sure of acts, and that it does not."""

from dataclasses import replace

import numpy as np
import pytest
from small_problems import noisy, small_recording, small_robot
from test_disturbances import under_a_couple, with_sensors

from orbident.estimation.estimate import Estimate
from orbident.estimation.momentum_problem import momentum_problems
from orbident.estimation.output_error.estimator import OutputError
from orbident.estimation.output_error.suspected import suspects_in_words
from orbident.recordings.recording import Recording

FAINT = 6e-6
"""N m: three of its deviations."""


def estimated(recording: Recording, *said: str) -> Estimate:
    robot = replace(with_sensors(small_robot()), disturbances=said)
    problem, *_ = momentum_problems(robot, recording, "at-rest", lambda _: None)
    return OutputError().estimate(problem, lambda _: None)


def test_mean_square_errors_are_those_of_a_fit_with_it_and_the_difference():
    recording = noisy(under_a_couple(FAINT), 0)
    plain, free = estimated(recording), estimated(recording, "torque")
    assert [*plain.suspected] == ["torque"]
    assert not plain.disturbances
    (words,) = suspects_in_words(plain.suspected)
    assert "--disturbance torque" in words
    one, other = plain.found.base, free.found.base
    square = np.diag(other.covariance) + (one.values - other.values) ** 2
    # To first order: what is left is of the second.
    assert np.diag(one.covariance) == pytest.approx(square, rel=0.02)


def test_nothing_is_suspected_where_nothing_acts():
    assert not estimated(noisy(small_recording(small_robot()), 0)).suspected
