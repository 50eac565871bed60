"""How far estimates are apart: one chi-square of two, and of several recordings."""

import numpy as np
import pytest
from scipy.stats import chi2
from small_problems import small_recording, small_robot

from orbident.estimation.base_parameters import BetaEstimate
from orbident.estimation.checks import Check
from orbident.estimation.estimate import Solved, estimate_of_beta
from orbident.estimation.levels import LEVELS, ChiSquare, chi_square, limit
from orbident.estimation.momentum_problem import MomentumProblem, momentum_problem
from orbident.estimation.several import agreement
from orbident.model.minimal_sets import minimal_sets

UNITS = np.array([1e3, 1.0, 1e-4])
ROBOT = small_robot()
BETA = minimal_sets(ROBOT).beta(ROBOT.theta)


def covariance(seed: int, size: np.ndarray) -> np.ndarray:
    random = np.random.default_rng(seed)
    root = np.eye(size.size) + 0.5 * random.standard_normal((size.size, size.size))
    return np.outer(size, size) * (root @ root.T)


def test_two_estimates_in_any_units():
    C, d = covariance(0, UNITS), 2 * UNITS
    found = chi_square(d, C)
    assert found.dof == 3
    assert found.value == pytest.approx(d @ np.linalg.solve(C, d))
    assert found.p == pytest.approx(chi2.sf(found.value, 3))


def test_a_direction_that_is_rounding_does_not_count():
    z = np.array([1.0, 2.0])
    J = np.array([[1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
    found = chi_square(J @ z, J @ J.T)
    assert found.dof == 2
    assert found.value == pytest.approx(z @ z)


def test_the_limit_of_a_rule():
    most = limit("comparison", 4)
    assert chi2.sf(most, 4) == pytest.approx(LEVELS["comparison"])
    assert ChiSquare(1.001 * most, 4).is_no_chance("comparison")
    assert not ChiSquare(0.999 * most, 4).is_no_chance("comparison")
    assert not ChiSquare(0.0, 0).is_no_chance("comparison")


def solved(problem: MomentumProblem, beta: np.ndarray, C: np.ndarray) -> Solved:
    known = BetaEstimate(beta, C, np.zeros((beta.size, 0)))
    estimate = estimate_of_beta(problem, known, "drawn", {}, None)
    return Solved(problem, [], estimate, None)


@pytest.fixture(scope="module")
def problem() -> MomentumProblem:
    recording = small_recording(ROBOT)
    return momentum_problem(ROBOT, recording, "unknown", lambda _: None)


def agreeing(problem: MomentumProblem, off: float) -> tuple[Check, float]:
    """Of four recordings, the third off by so many deviations; and Cochran's sum."""
    random = np.random.default_rng(1)
    deviations = [np.abs(BETA) * 10.0**-k + 1e-3 for k in (2, 3, 1, 2)]
    C = [covariance(k, std) for k, std in enumerate(deviations)]
    b = [random.multivariate_normal(BETA, each) for each in C]
    b[2] = b[2] + off * np.sqrt(np.diag(C[2]))
    A = [np.linalg.inv(each) for each in C]
    mean = np.linalg.solve(sum(A), sum(A[k] @ b[k] for k in range(4)))
    Q = sum((b[k] - mean) @ A[k] @ (b[k] - mean) for k in range(4))
    every = [solved(problem, b[k], C[k]) for k in range(4)]
    return agreement(every, ["a", "b", "c", "d"]), float(Q)


def test_several_agree(problem: MomentumProblem):
    found, Q = agreeing(problem, 0.0)
    assert found.level == "trust"
    assert found.statistic == pytest.approx(Q, rel=1e-3)
    assert found.limit == pytest.approx(limit("same robot", 3 * BETA.size))


def test_the_one_that_differs_is_named(problem: MomentumProblem):
    found, Q = agreeing(problem, 30.0)
    assert found.level == "do not trust"
    assert found.statistic == pytest.approx(Q, rel=1e-3)
    assert found.reason.startswith("c does not show the same robot as the others")
