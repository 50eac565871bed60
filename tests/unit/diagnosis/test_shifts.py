"""Sensors whose error has a course in time."""

import numpy as np
from cause_problems import clean, fitted, numbers, with_recording

from orbident.diagnosis.shifts import drifts, less, vibrations


def test_an_attitude_that_drifts():
    recording = clean().recording
    error = np.outer(recording.t / recording.t[-1], [0.01, 0.0, -0.02])
    problem = with_recording(less(recording, "attitude", -error))
    _, attitude = drifts(problem)
    found = numbers(problem, attitude)
    # To first order of a turn by 1 degree.
    np.testing.assert_allclose(found, [0.01, 0.0, -0.02], atol=1e-3)
    assert "the attitude drifts" in attitude.words(found)


def test_a_tracked_point_that_swings():
    """A swing at 0.63 Hz is found: 2 mm along x, and half as much along y."""
    recording = clean().recording
    phase = 2 * np.pi * 0.63 * recording.t
    swing = np.column_stack([np.sin(phase), 0.5 * np.cos(phase), 0 * phase])
    problem = with_recording(less(recording, "position", -2e-3 * swing))
    (suspect,) = vibrations(problem, fitted(problem))
    found = numbers(problem, suspect).reshape(2, 3)
    # The line's frequency is known to a small part of one over the recording's length.
    np.testing.assert_allclose(np.hypot(*found), [2e-3, 1e-3, 0.0], atol=2e-4)
    assert "at 0.63 Hz" in suspect.words(found.ravel())


def test_noise_is_no_swing():
    problem = with_recording(clean().recording)
    assert [*vibrations(problem, fitted(problem))] == []
