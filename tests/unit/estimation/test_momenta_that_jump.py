"""A push is looked for where it shows in the linear equations, and nowhere else."""

import numpy as np
import pytest
from cause_problems import clean, problem_with
from edited_recordings import changed

from orbident.estimation.estimate import Solved
from orbident.estimation.momentum_problem import momentum_problem
from orbident.estimation.output_error.estimator import OutputError
from orbident.estimation.pushes import LEAVES, jump_of_momenta, with_push


def test_a_jump_of_the_velocity_leaves_little():
    """By 0.05 m/s at 12 s, as a push gives it; positions go on from there."""
    recording = clean().recording
    later = np.maximum(recording.t - 12.0, 0.0)
    pushed = changed(
        recording, {"position.x": recording.column("position.x") + 0.05 * later}
    )
    problem = momentum_problem(clean().robot, pushed, "unknown", lambda _: None)
    row, left = jump_of_momenta(problem)
    assert abs(problem.samples.t[row] - 12.0) < 1.0
    assert left < LEAVES


def test_what_is_no_push_is_not_fitted_as_one(monkeypatch: pytest.MonkeyPatch):
    """A scale of a joint leaves more of both equations with a jump at any time."""
    wrong = problem_with({"joint.joint2.position": lambda q: 1.05 * q})
    shown = OutputError().estimate(wrong, lambda _: None)
    solved = Solved(wrong, [], shown, shown)
    assert jump_of_momenta(wrong.amended())[1] > LEAVES
    fits = 0

    def counted(*_: object) -> None:
        nonlocal fits
        fits += 1

    monkeypatch.setattr(OutputError, "estimate", counted)
    assert with_push(solved, OutputError(), lambda _: None) is solved
    assert fits == 0
