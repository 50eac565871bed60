"""Clocks that are late or early."""

from cause_problems import clean

from orbident.diagnosis.late_clocks import clocks
from orbident.estimation.momentum_problem import momentum_problems
from orbident.recordings.recording import Recording


def test_a_position_that_is_a_row_early():
    """A row is 0.1 s; what is shown at a time is what was there a row later."""
    recording = clean().recording
    columns = {
        name: column[1:] if name.startswith("position") else column[:-1]
        for name, column in recording.columns.items()
    }
    early = Recording(recording.t[:-1], columns)
    problem = momentum_problems(clean().robot, early, "unknown", lambda _: None)[0]
    (found,) = clocks(problem)
    assert found.accepted
    assert found.cause == "the clock of the position is 100 ms early"
