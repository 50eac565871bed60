"""The parts of a covariance, against equations stacked and weighed at once."""

from dataclasses import replace

import numpy as np
import pytest
from small_problems import (
    Small,
    noisy,
    noisy_in_space,
    small_flight,
    small_problem,
    small_robot,
    small_robot_in_space,
)
from test_lasting_noise import LASTS, tracker_rows
from test_solving import dense

from orbident.estimation.budget import ErrorSources
from orbident.estimation.output_error.covariance_parts import covariance_parts
from orbident.estimation.output_error.problem import linear
from orbident.estimation.output_error.solver import solution_at, solved
from orbident.estimation.solution import OUTSIDE, Prior, Solution
from orbident.robot.sensor_schema import declared_sensors
from orbident.robot.tolerances import Tolerances

ZERO = 0.05
"""rad: tolerance of an encoder's zero, which a recording shows better than that."""


@pytest.fixture(scope="module", params=["table", "lasting noise", "space"])
def small(request) -> Small:
    space = request.param == "space"
    robot = small_robot_in_space() if space else small_robot()
    recording = small_flight(robot)
    if request.param == "lasting noise":
        robot = replace(robot, sensors=declared_sensors(LASTS))
    joint = robot.joint_names[0]
    tolerances = Tolerances(joint_zero={joint: ZERO}, gyro_scale=1e-3)
    shown = (noisy_in_space if space else noisy)(recording, 0)
    return small_problem(replace(robot, tolerances=tolerances), shown)


def solution_of(small: Small, prior: Prior, **raised: float) -> Solution:
    """The equations where the search starts, with some sensors' information raised."""
    weights = {
        name: np.sqrt(raised.get(name, 1.0)) * table
        for name, table in small.problem.weights.items()
    }
    here = linear(small.problem, weights, small.state)
    return solution_at(small.state, here, prior, weights, True, 0.0)


def of_beta(small: Small, solution: Solution) -> np.ndarray:
    first = solution.linear.local + OUTSIDE
    which = slice(first, first + small.beta.size)
    return solution.covariance[which, which]


@pytest.fixture(scope="module")
def solution(small) -> Solution:
    return solution_of(small, small.prior)


@pytest.fixture(scope="module")
def found(small, solution) -> ErrorSources:
    return covariance_parts(small.problem, solution)


@pytest.mark.parametrize("small", ["table", "space"], indirect=True)
def test_they_are_those_of_the_stacked_equations(small, found):
    problem, prior, state, _ = small
    _, C = dense(problem, state).with_prior(prior, state).solution()
    first = state.local.size + OUTSIDE
    columns = C[:, first : first + small.beta.size]
    std = np.sqrt(np.diag(C))[first : first + small.beta.size]
    # Those of encoders are in small triangles with the prior of corrections.
    for name in {*problem.weights} - {"joints"}:
        shown = tracker_rows(small, name)[:, :-1] @ columns
        part = shown.T @ shown
        # Continuity weighs so much that rounding leaves a millionth.
        off = (found[name].part - part) / np.outer(std, std)
        assert np.abs(off).max() < 1e-5, name


@pytest.mark.parametrize("searched", [False, True])
@pytest.mark.parametrize("kept", [False, True])
def test_they_add_up_to_the_covariance(small, searched, kept):
    """The search ends a small step beyond the state of its equations."""
    problem, prior, state, _ = small
    solution = solution_of(small, prior)
    if searched:
        solution = solved(problem, problem.weights, prior, state)
        assert solution.state is not solution.linear.at
    if not kept:
        solution = solution._replace(linear=solution.linear.without_rows())
    found = covariance_parts(problem, solution)
    whole = of_beta(small, solution)
    std = np.sqrt(np.diag(whole))
    total = np.sum([each.part for each in found.values()], axis=0)
    assert np.abs((total - whole) / np.outer(std, std)).max() < 1e-6
    for name, each in found.items():
        assert np.diag(each.part).min() >= 0, name


def test_a_share_says_how_the_variance_falls_with_more_information(small, found):
    """-d ln C_ii / d ln lambda, with the weights and the lasting noise of a sensor."""
    C = np.diag(np.sum([each.part for each in found.values()], axis=0))
    step = 1e-3
    for name in small.problem.weights:
        more, less = (
            np.diag(of_beta(small, solution_of(small, small.prior, **{name: raised})))
            for raised in (np.exp(step), np.exp(-step))
        )
        expected = -np.log(more / less) / (2 * step)
        share = np.diag(found[name].part) / C
        # Not raised are what corrections of joints, 10 mrad, and the first values of
        # lasting noise are beforehand; they are in the parts, and are hardly anything.
        beforehand = 0.02 if small.problem.lasting.any() else 0.0
        assert (share > expected - 1e-5).all(), name
        assert (share < expected + beforehand + 1e-5).all(), name


def test_what_a_tolerance_costs_is_what_perfect_instruments_save(small, found):
    families = {each.family for each in small.problem.declared}
    assert families <= {*found}
    for family in families:
        std = small.prior.std.copy()
        for k, each in enumerate(small.problem.declared):
            if each.family == family:
                std[OUTSIDE + small.beta.size + k] = 1e-12
        known = of_beta(small, solution_of(small, small.prior._replace(std=std)))
        assert found[family].kind == "instrument"
        assert found[family].known is not None
        off = np.diag(found[family].known) / np.diag(known) - 1
        assert np.abs(off).max() < 1e-6, family


def test_less_of_a_source_leaves_no_more_than_the_bound(small, found):
    """`1 - f (1 - 1/r^2)` of the variance, for a sensor that is `r` times better."""
    C = np.diag(np.sum([each.part for each in found.values()], axis=0))
    for name in small.problem.weights:
        better = solution_of(small, small.prior, **{name: 3.0**2})
        left = np.diag(of_beta(small, better)) / C
        f = np.diag(found[name].part) / C
        assert (left <= 1 - f * (1 - 3.0**-2) + 1e-6).all(), name
