"""Sensors whose clock runs fast beside the others'."""

from dataclasses import replace

import numpy as np
import pytest
from cause_problems import clean, fitted, problem_with
from scipy.interpolate import CubicSpline

from orbident.diagnosis.late_clocks import fast_clocks
from orbident.diagnosis.suspects import Scores

RATE = 0.002


def test_joints_and_the_tracker_may_have_clocks_of_their_own():
    words = [each.words(np.array([-0.01])) for each in fast_clocks(problem_with())]
    assert words == [
        f"the clock of the {name} runs 1 % slow" for name in ("joints", "position")
    ]


@pytest.mark.parametrize("sensor", ["joints", "position"])
def test_a_clock_that_runs_fast(sensor: str):
    recording = clean().recording
    t = recording.t
    at = t[0] + (1 + RATE) * (t - t[0])

    def fast(x: np.ndarray) -> np.ndarray:
        return CubicSpline(t, x)(at)

    names = ("joint.", "wheel.") if sensor == "joints" else "position."
    problem = problem_with(
        {name: fast for name in recording.columns if name.startswith(names)}
    )
    (suspect,) = (
        each for each in fast_clocks(problem) if sensor in each.words(np.ones(1))
    )
    solution = fitted(problem).solution
    assert solution is not None
    (score,) = Scores(problem, solution).of([suspect])
    found = score.values
    # The end of a recording is 60 ms late, which shows in second order too.
    np.testing.assert_allclose(found[0], RATE, rtol=0.15)


def test_a_sensor_that_was_not_recorded_has_no_clock():
    problem = problem_with()
    recording = problem.recording
    columns = {n: x for n, x in recording.columns.items() if "position." not in n}
    bare = replace(problem, recording=replace(recording, columns=columns))
    assert [*fast_clocks(bare)][1:] == []
