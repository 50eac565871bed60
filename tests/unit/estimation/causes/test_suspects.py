"""Numbers that may be wrong, found to first order, and tried."""

import numpy as np
from cause_problems import clean, fitted, problem_with

from orbident.estimation.causes.frames import beside
from orbident.estimation.causes.suspects import Score, Suspect, score
from orbident.estimation.problem import MomentumProblem


def best(problem: MomentumProblem, suspects) -> tuple[Suspect, Score]:
    solution = fitted(problem).solution
    assert solution is not None
    scores = [(each, score(problem, solution, each)) for each in suspects]
    return max(scores, key=lambda one: one[1].falls)


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
    assert "different inertial axes" in suspect.words(first.numbers)
    np.testing.assert_allclose(
        first.numbers, [0.0, 0.0, -0.02], atol=5 * first.std.max()
    )
