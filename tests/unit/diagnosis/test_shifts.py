"""Sensors whose error has a course in time."""

import numpy as np
from cause_problems import clean, numbers, with_recording

from orbident.diagnosis.shifts import drifts, less


def test_an_attitude_that_drifts():
    recording = clean().recording
    error = np.outer(recording.t / recording.t[-1], [0.01, 0.0, -0.02])
    problem = with_recording(less(recording, "attitude", -error))
    _, attitude = drifts(problem)
    found = numbers(problem, attitude)
    # To first order of a turn by 1 degree.
    np.testing.assert_allclose(found, [0.01, 0.0, -0.02], atol=1e-3)
    assert "the attitude drifts" in attitude.words(found)
