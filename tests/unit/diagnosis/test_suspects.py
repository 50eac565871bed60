"""Numbers that may be wrong, found to first order, and tried."""

from dataclasses import replace

import numpy as np
from cause_problems import clean, fitted, problem_with
from edited_recordings import changed

from orbident.diagnosis.frames import beside, missing_wheel
from orbident.diagnosis.suspects import Scores, Suspect
from orbident.estimation.momentum_problem import MomentumProblem, momentum_problem
from orbident.estimation.unknowns import Score


def best(problem: MomentumProblem, suspects) -> tuple[Suspect, Score]:
    solution = fitted(problem).solution
    assert solution is not None
    scores = [(each, Scores(problem, solution).of(each)) for each in suspects]
    return max(scores, key=lambda one: one[1].fall)


def test_inertial_axes():
    """Positions turned by 20 mrad about z."""
    c, s = np.cos(0.02), np.sin(0.02)
    columns = clean().recording.columns
    x, y = columns["position.x"], columns["position.y"]
    problem = problem_with(
        {
            "position.x": lambda _: c * x - s * y,
            "position.y": lambda _: s * x + c * y,
        }
    )
    suspect, first = best(problem, beside(problem))
    assert "different inertial axes" in suspect.words(first.values)
    np.testing.assert_allclose(
        first.values, [0.0, 0.0, -0.02], atol=5 * first.std.max()
    )


def test_a_wheel_that_the_robot_file_lacks():
    """One of three is missing; what it has along the other two together is another
    scale."""
    robot, gone = clean().robot, clean().robot.wheels[0]
    recording = changed(
        clean().recording,
        keep=lambda name: not name.startswith(f"wheel.{gone.name}."),
    )
    fewer = replace(robot, wheels=robot.wheels[1:])
    problem = momentum_problem(fewer, recording, "unknown", lambda _: None)
    (found,) = missing_wheel(problem)
    assert found.accepted
    assert "a wheel is missing" in found.cause


def test_no_wheel_is_missing():
    assert [*missing_wheel(problem_with())] == []
