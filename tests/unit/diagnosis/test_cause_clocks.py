"""Clocks that are late or early."""

from dataclasses import replace

import numpy as np
import pytest
from cause_problems import clean
from small_problems import small_recording, small_robot

from orbident.diagnosis.causes import causes
from orbident.diagnosis.late_clocks import (
    SHARED,
    _behind,
    already_corrected,
    clocks,
    far_off,
)
from orbident.errors import InputError
from orbident.estimation.estimate import Solved
from orbident.estimation.least_squares import LeastSquares
from orbident.estimation.momentum_problem import momentum_problem
from orbident.estimation.output_error.estimator import OutputError
from orbident.preprocessing.delays import Delay
from orbident.recordings.recording import Recording


@pytest.mark.slow
def test_a_position_that_is_a_row_early():
    """A row is 0.1 s; what is shown at a time is what was there a row later."""
    recording = clean().recording
    columns = {
        name: column[1:] if name.startswith("position") else column[:-1]
        for name, column in recording.columns.items()
    }
    early = Recording(recording.t[:-1], columns)
    problem = momentum_problem(clean().robot, early, "unknown", lambda _: None)
    (found,) = clocks(problem, far_off(problem))
    assert found.accepted
    assert found.cause == "the clock of the position is 100 ms early"


def test_joints_whose_clock_was_never_set():
    """They are seconds early: what they show is what was there later."""
    recording, rows = clean().recording, 25
    columns = {
        name: column[rows:] if name.startswith(("joint", "wheel")) else column[:-rows]
        for name, column in recording.columns.items()
    }
    early = Recording(recording.t[:-rows], columns)
    problem = momentum_problem(clean().robot, early, "unknown", lambda _: None)
    found = far_off(problem)
    seconds = float(recording.t[rows] - recording.t[0])
    assert found["joints"] == pytest.approx(-seconds, abs=0.05)
    assert not found["attitude"]
    assert not found["position"]


def test_a_clock_that_is_off_by_the_whole_recording():
    """Nothing can be fitted to what is left, and the search goes on without it."""
    robot = small_robot()
    short = small_recording(robot).between(0.0, 1.0)
    problem = momentum_problem(robot, short, "at-rest", lambda _: None)
    late = dict.fromkeys(SHARED, 0.0) | {"position": 0.98}
    with pytest.raises(InputError, match="known together at 1 times"):
        OutputError().estimate(_behind(problem, late), lambda _: None)


def test_a_clock_of_what_was_recorded():
    """What shares a clock is not named: here nobody recorded a position."""
    columns = {
        name: column
        for name, column in clean().recording.columns.items()
        if not name.startswith("position")
    }
    recording = Recording(clean().recording.t, columns)
    problem = momentum_problem(clean().robot, recording, "unknown", lambda _: None)
    late = {"attitude": Delay(2e-3, 1e-5, True)}
    corrected = already_corrected(replace(problem, clocks=late))
    assert corrected is not None
    assert corrected.cause == "the clock of the attitude is 2 ms late"


def test_times_that_were_kept_as_float32():
    """For a week on: nothing else is tried."""
    recording = clean().recording
    t = (recording.t + 604_800.0).astype(np.float32).astype(float)
    rounded = Recording(t, recording.columns)
    problem = momentum_problem(clean().robot, rounded, "unknown", lambda _: None)
    nothing = LeastSquares().estimate(problem, lambda _: None)
    (found,) = causes(Solved(problem, [], nothing, None))
    assert found.reason == "the times were kept as float32, in steps of 0.062 s"
