"""Numbers that cannot be: what no method may take for an answer."""

from dataclasses import replace

import numpy as np
import pytest
from small_problems import noisy, small_recording, small_robot

from orbident.estimation.criteria import judge
from orbident.estimation.estimate import Estimate, Solved
from orbident.estimation.least_squares import LeastSquares
from orbident.estimation.momentum_problem import MomentumProblem, momentum_problem
from orbident.estimation.output_error.torques import possible_motors
from orbident.estimation.quantities import Quantity
from orbident.estimation.unknowns import DriveFit


@pytest.fixture(scope="module")
def problem() -> MomentumProblem:
    robot = small_robot()
    recording = noisy(small_recording(robot), 0)
    return momentum_problem(robot, recording, "at-rest", lambda _: None)


@pytest.fixture(scope="module")
def estimate(problem: MomentumProblem) -> Estimate:
    return LeastSquares().estimate(problem, lambda _: None)


def refused(problem: MomentumProblem, estimate: Estimate) -> list[str]:
    checks = judge(
        Solved(problem, [], estimate, None), {"Eq. 32": estimate.mass}
    ).checks
    return [check.reason for check in checks if check.name == "possible numbers"]


def test_numbers_that_can_be(problem, estimate):
    assert not refused(problem, estimate)


@pytest.mark.parametrize(
    ("mass", "words"),
    [
        (Quantity(np.nan, np.nan), "is no number"),
        (Quantity(10.0, np.inf), "is no number"),
        (Quantity(-3.0, 0.1), "found -3 kg, which no robot has"),
    ],
)
def test_a_mass_that_is_none(problem, estimate, mass, words):
    (reason,) = refused(problem, replace(estimate, mass=mass))
    assert words in reason


def test_a_parameter_that_is_none(problem, estimate):
    found = estimate.parameters
    lost = found.pi._replace(values=np.full_like(found.pi.values, np.nan))
    changed = replace(estimate, parameters=found._replace(pi=lost))
    (reason,) = refused(problem, changed)
    assert "is no number" in reason


@pytest.mark.parametrize("part", ["armature", "viscous", "coulomb"])
def test_a_motor_takes_no_less_than_nothing(part):
    """By five deviations: torques of the other sign make it so."""
    nothing = DriveFit(*[0.0, 1.0] * 4)
    little, less = (nothing._replace(**{part: value}) for value in (-4.9, -5.1))
    assert not [*possible_motors({"elbow": little})]
    (check,) = possible_motors({"elbow": less})
    assert check.level == "do not trust"
    assert "joint 'elbow' would be -5.1 +- 1" in check.reason
    assert not [*possible_motors({"elbow": nothing._replace(offset=-9.0)})]
