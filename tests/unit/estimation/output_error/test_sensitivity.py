"""Shifts by undeclared calibration errors, against estimates that have them."""

from dataclasses import replace

import numpy as np
import pytest
from instruments import Errors, no_errors, shown_with
from small_problems import (
    Small,
    small_flight,
    small_problem,
    small_robot,
    small_robot_in_space,
)

from orbident.estimation.output_error.problem import linear
from orbident.estimation.output_error.solver import solved
from orbident.estimation.output_error.taken_for_zero import (
    SMALL_ERROR,
    TakenForZero,
    sensitivity,
)
from orbident.estimation.solution import Solution
from orbident.estimation.unknowns import score
from orbident.model.minimal_sets import minimal_sets
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.tolerances import Tolerances

NOISE = 1e-3
"""Standard deviation of all sensors, SI."""


def one_by_one(robot: Robot, size: float) -> list[Errors]:
    """Every calibration error alone, by its place."""
    count = no_errors(robot).vector.size
    lengths = [len(part) for part in vars(no_errors(robot)).values()]
    ends = np.cumsum(lengths)[:-1]
    return [Errors(*np.split(row, ends)) for row in size * np.eye(count)]


@pytest.fixture(
    scope="module", params=["planar", pytest.param("spatial", marks=pytest.mark.slow)]
)
def flown(request) -> tuple[Robot, Recording]:
    """A robot and what perfect instruments recorded of it."""
    robot = small_robot() if request.param == "planar" else small_robot_in_space()
    return robot, small_flight(robot)


def test_shifts_are_those_of_estimates_from_such_instruments(flown):
    """Every error by itself, so small that nothing bends."""
    robot, recording = flown
    size = 1e-5
    problem, prior, state, _ = small_problem(robot, recording)
    solution = solved(problem, problem.weights, prior, state)
    table = sensitivity(TakenForZero(problem, solution))
    std = np.sqrt(np.diag(table.covariance))
    errors = one_by_one(robot, size)
    assert table.names == tuple(each.name for each in problem.instruments)
    for k, each in enumerate(problem.instruments):
        error = errors[int(each.place)]
        shown = shown_with(error, robot, small_flight(error.robot(robot)))
        # With the weights of the recording without errors.
        there = small_problem(robot, shown).problem
        again = solved(there, problem.weights, prior, solution.state)
        _, unit = SMALL_ERROR[each.unit]
        expected = (again.state.beta - solution.state.beta) / std * unit / size
        found = table.shift[:, k] / std
        # Each solution stops within a hundredth of a deviation of its own.
        assert np.abs(found - expected).max() < 1e-2 * np.abs(found).max() + 1e-2, (
            each.name
        )


def test_shifts_in_deviations_of_what_follows_from_beta(flown):
    robot, recording = flown
    sets = minimal_sets(robot)
    problem, prior, state, beta = small_problem(robot, recording)
    table = sensitivity(
        TakenForZero(problem, solved(problem, problem.weights, prior, state))
    )
    for derivative in sets.derivatives(beta):
        found = table.in_deviations(derivative)
        assert found.shape == (len(derivative), len(table.names))
        row = derivative[0]
        std = np.sqrt(row @ table.covariance @ row)
        expected = row @ table.shift / std
        rounding = 1e-14 * np.abs(expected).max()
        np.testing.assert_allclose(found[0], expected, atol=rounding)


def test_an_error_freed_alone_is_what_a_refit_finds(flown):
    """Its value, its deviation and what chi-square loses."""
    robot, recording = flown
    random = np.random.default_rng(0)
    shown = {
        name: column + NOISE * random.standard_normal(column.size)
        for name, column in recording.columns.items()
        if name.startswith(("gyro", "position", "velocity"))
    }
    recording = Recording(recording.t, recording.columns | shown)
    exact = small_problem(robot, recording)
    weights = by_noise(exact)
    solution = solved(exact.problem, weights, exact.prior, exact.state)
    alone = sensitivity(TakenForZero(exact.problem, solution)).alone
    free = Tolerances(position_scale=1.0)
    small = small_problem(replace(robot, tolerances=free), recording)
    again = solved(small.problem, weights, small.prior, small.state)
    std = np.sqrt(again.covariance[-1, -1])
    (value,), (found,), fall = alone["position.scale"]
    assert abs(value - again.state.calibration[0]) < 0.02 * std
    np.testing.assert_allclose(found, std, rtol=0.01)
    drop = cost(exact, solution) - cost(small, again)
    assert abs(fall - drop) < 0.01 * (1 + drop)


def by_noise(small: Small) -> dict[str, np.ndarray]:
    """Weights of sensors that all have the noise `NOISE`."""
    weights = small.problem.weights.items()
    return {name: (weight > 0) / NOISE for name, weight in weights}


def cost(small: Small, solution: Solution) -> float:
    problem, prior, _, _ = small
    at = linear(problem, solution.weights, solution.state)
    return at.cost + prior.cost(solution.state)


def test_the_cause_of_a_misfit_has_the_largest_drop(flown):
    """A position that is 0.5 % too large, beside a velocity that is not."""
    robot, recording = flown
    errors = replace(no_errors(robot), position=np.array([5e-3]))
    small = small_problem(robot, shown_with(errors, robot, recording))
    solution = solved(small.problem, by_noise(small), small.prior, small.state)
    alone = sensitivity(TakenForZero(small.problem, solution)).alone
    cause = max(alone, key=lambda name: alone[name].fall)
    assert cause == "position.scale"
    # All of chi-square is its doing, but for what bends.
    (value,), (std,), fall = alone[cause]
    assert value == pytest.approx(5e-3, rel=0.05)
    assert fall == pytest.approx(cost(small, solution), rel=0.05)
    assert value > 20 * std


def test_what_nothing_shows_has_an_infinite_deviation():
    """The scale of an encoder that shows zero all the time."""
    (value,), (std,), fall = score(np.zeros((3, 1)), np.ones(3))
    assert (value, std, fall) == (0.0, np.inf, 0.0)
