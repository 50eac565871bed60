"""Steps that no smooth motion makes."""

import numpy as np
import pytest
from cause_problems import clean, fitted, problem_with, with_recording

from orbident.diagnosis import jumps as module
from orbident.diagnosis.jumps import jumping, jumps, steps
from orbident.diagnosis.shifts import less
from orbident.diagnosis.suspects import Scores
from orbident.estimation.momentum_problem import MomentumProblem, momentum_problem
from orbident.preprocessing.leaps import Jump
from orbident.recordings.recording import Recording

ONES = np.ones(3)


def test_a_joint_that_slips_is_put_right():
    later = np.arange(301) >= 150
    problem = problem_with(
        {"joint.joint2.position": lambda q: q + 0.02 * later[: q.size]}
    )
    (found,) = jumps(problem, fitted(problem), np.inf)
    assert found.accepted
    assert "joint joint2 slips" in found.cause
    assert "t = 15 s" in found.cause


def test_a_joint_that_bends_seems_to_jump_and_that_explains_nothing(monkeypatch):
    """What a fast motion looks like between samples is no trial worth."""
    problem = problem_with()
    seen = Jump("joint.joint2", 150, 100.0, np.array([1e-6]), np.array([0.0]))
    monkeypatch.setattr(
        module, "jumps_of", lambda sensor, *_: [seen] * (sensor == seen.sensor)
    )
    assert [*jumps(problem, fitted(problem), np.inf)] == []


def problem_at(t: np.ndarray, rows: np.ndarray) -> MomentumProblem:
    """Some rows of the clean recording, stamped with other times."""
    columns = {name: x[rows] for name, x in clean().recording.columns.items()}
    recording = Recording(t[rows], columns)
    return momentum_problem(clean().robot, recording, "unknown", lambda _: None)


@pytest.mark.parametrize(
    ("by", "way"), [(0.05, "forward"), (2.0, "forward"), (-0.05, "back")]
)
def test_a_clock_that_is_set(by: float, way: str):
    """The times of rows say so, by whole steps or not."""
    later = np.arange(301) >= 150
    problem = problem_at(clean().recording.t + by * later, np.arange(301))
    found = next(jumps(problem, fitted(problem), np.inf))
    assert found.accepted
    at = f"by {abs(by):g} s at t = {15 + by:g} s"
    assert f"the clock was set {way} {at}" in found.cause


def test_a_gap_is_no_clock_that_is_set():
    rows = np.flatnonzero(np.abs(np.arange(301) - 150) > 10)
    problem = problem_at(clean().recording.t, rows)
    assert not any(one.accepted for one in jumps(problem, fitted(problem), np.inf))


@pytest.mark.slow
def test_a_gyro_that_jumps_by_less_than_it_shows():
    """In the gyro's residuals the step stands out, and its row and size are found."""
    later = np.arange(301) >= 150
    problem = problem_with({"gyro.y": lambda w: w + 5e-4 * later[: w.size]})
    shown = fitted(problem)
    assert [*jumps(problem, shown, np.inf)] == []
    suspect = next(each for each in steps(problem, shown) if "gyro" in each.words(ONES))
    assert shown.solution is not None
    (first,) = Scores(problem, shown.solution).of([suspect])
    assert "t = 15 s" in suspect.words(first.values)
    far = 5 * first.std.max()
    np.testing.assert_allclose(first.values, [0.0, 5e-4, 0.0], atol=far)


def test_markers_that_are_taken_for_others_for_a_while():
    recording = clean().recording
    row = np.arange(recording.t.size)
    error = np.outer((row >= 120) & (row < 180), [0.0, 0.0, 0.05])
    problem = with_recording(less(recording, "attitude", -error))
    (found,) = jumps(problem, fitted(problem), np.inf)
    assert found.accepted
    assert "the attitude has jumps" in found.cause
    assert "t = 12, 18 s" in found.cause


def test_a_position_that_jumps():
    recording = clean().recording
    error = np.outer(np.arange(recording.t.size) >= 120, [0.0, 0.01, 0.0])
    problem = with_recording(less(recording, "position", -error))
    solution = fitted(problem).solution
    assert solution is not None
    (found,) = Scores(problem, solution).of([jumping(problem, "position", [120])])
    np.testing.assert_allclose(found.values, [0.0, 0.01, 0.0], atol=1e-3)
