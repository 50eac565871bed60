"""Deviations hold that what is too faint to be sure of acts, and that it does not."""

from dataclasses import replace

import numpy as np
import pytest
from small_problems import noisy, small_recording, small_robot
from test_disturbances import under_a_couple, with_sensors

from orbident.estimation.estimate import Estimate
from orbident.estimation.levels import limit
from orbident.estimation.momentum_problem import momentum_problem
from orbident.estimation.output_error.estimator import OutputError
from orbident.estimation.output_error.sensitivity import undecided_in_words
from orbident.estimation.unknowns import UNSEEN
from orbident.recordings.recording import Recording

FAINT = 6e-6
"""N m: three of its deviations."""


def estimated(recording: Recording, *said: str) -> Estimate:
    robot = replace(with_sensors(small_robot()), disturbances=said or None)
    problem = momentum_problem(robot, recording, "at-rest", lambda _: None)
    return OutputError().estimate(problem, lambda _: None)


def test_mean_square_errors_are_those_of_a_fit_with_it_and_the_difference():
    recording = noisy(under_a_couple(FAINT), 0)
    plain, free = estimated(recording), estimated(recording, "torque")
    assert [*plain.suspected] == ["torque"]
    assert not plain.disturbances
    (words,) = undecided_in_words(plain.suspected, ())
    assert "--disturbance torque" in words
    one, other = plain.found.base, free.found.base
    square = np.diag(other.covariance) + (one.values - other.values) ** 2
    # To first order: what is left is of the second.
    assert np.diag(one.covariance) == pytest.approx(square, rel=0.02)


def test_who_says_what_acts_suspects_nothing_else():
    recording = noisy(under_a_couple(FAINT), 0)
    assert [*estimated(recording).suspected] == ["torque"]
    assert not estimated(recording, "pull").suspected


def test_nothing_is_suspected_where_nothing_acts():
    assert not estimated(noisy(small_recording(small_robot()), 0)).suspected


def test_what_hides_shifts_as_much_as_the_table_says():
    """Deviations grow by as much where the group is among the unknowns."""
    recording = noisy(small_recording(small_robot()), 0)
    plain = estimated(recording)
    assert plain.sensitivity is not None
    table = plain.sensitivity()
    unseen = {
        name: shift
        for name, unit, shift in zip(
            table.names, table.units, table.shift.T, strict=True
        )
        if unit == UNSEEN
    }
    for group, numbers in (("torque", 1), ("pull", 2), ("uneven", 3)):
        free = estimated(recording, group)
        C, D = (np.diag(each.found.base.covariance) for each in (plain, free))
        # The largest that it can be while chi-square would fall by no more than that.
        most = limit("suspicion", numbers, len(unseen))
        # The noise is estimated with the parameters, and differs by some percent.
        np.testing.assert_allclose(C + unseen[group] ** 2 / most, D, rtol=0.05)
