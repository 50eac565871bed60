"""Sensors whose error has a course in time, and joints that give way."""

import numpy as np
from cause_problems import clean, fitted, problem_with

from orbident.diagnosis.shifts import drifts, joint_errors, less, step
from orbident.diagnosis.suspects import Scores, Suspect
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.recordings.recording import Recording


def numbers(problem: MomentumProblem, suspect: Suspect) -> np.ndarray:
    solution = fitted(problem).solution
    assert solution is not None
    return Scores(problem, solution).of(suspect).values


def with_recording(recording: Recording) -> MomentumProblem:
    return problem_with(
        {name: lambda _, x=x: x for name, x in recording.columns.items()}
    )


def test_an_attitude_that_drifts():
    recording = clean().recording
    error = np.outer(recording.t / recording.t[-1], [0.01, 0.0, -0.02])
    problem = with_recording(less(recording, "attitude", -error))
    _, attitude = drifts(problem)
    found = numbers(problem, attitude)
    # To first order of a turn by 1 degree.
    np.testing.assert_allclose(found, [0.01, 0.0, -0.02], atol=1e-3)
    assert "the attitude drifts" in attitude.words(found)


def test_a_position_that_jumps():
    recording = clean().recording
    error = np.outer(np.arange(recording.t.size) >= 120, [0.0, 0.01, 0.0])
    problem = with_recording(less(recording, "position", -error))
    found = numbers(problem, step(problem, "position", 120))
    np.testing.assert_allclose(found, [0.0, 0.01, 0.0], atol=1e-3)


def test_joints_that_give_way():
    """`q_m = q + qdd / (2 pi f)^2`, by differences of the joints' rates."""
    soft = 1 / (2 * np.pi * 2.0) ** 2
    problem = problem_with()
    t, qd = problem.samples.t, np.array(problem.samples.qd)
    recording = clean().recording
    for name, rate in zip(clean().robot.joint_names, qd, strict=True):
        bent = soft * np.gradient(rate, t)
        recording = less(recording, f"joint.{name}", -bent[:, None])
    problem = with_recording(recording)
    *_, suspect = joint_errors(problem)
    found = numbers(problem, suspect)
    # Differences over 0.1 s, and joints that smoothing has made a little slower.
    np.testing.assert_allclose(found, soft, rtol=0.3)
    assert "gives way" in suspect.words(found)


def test_an_encoder_that_drifts():
    recording = clean().recording
    elapsed = (recording.t - recording.t[0]) / (recording.t[-1] - recording.t[0])
    wrong = less(recording, "joint.joint2", -5e-3 * elapsed[:, None])
    problem = with_recording(wrong)
    suspect, *_ = joint_errors(problem)
    found = numbers(problem, suspect)
    np.testing.assert_allclose(found, [0.0, 5e-3, 0.0], atol=5e-4)
    assert "joint joint2: its position drifts" in suspect.words(found)


def test_an_encoder_off_the_centre_of_its_axis():
    recording = clean().recording
    q = recording.columns["joint.joint2.position"]
    wrong = less(recording, "joint.joint2", -5e-3 * np.sin(q)[:, None])
    problem = with_recording(wrong)
    _, suspect, *_ = joint_errors(problem)
    found = numbers(problem, suspect)
    np.testing.assert_allclose(found[2:4], [5e-3, 0.0], atol=5e-4)
    assert "the encoder of joint joint2 is off the centre" in suspect.words(found)


def test_a_gear_with_play():
    """The motor is ahead of the link by half of it, on the side to which it turns."""
    recording = clean().recording
    q = recording.columns["joint.joint2.position"]
    ahead = np.sign(np.gradient(q, recording.t))
    problem = with_recording(less(recording, "joint.joint2", -5e-4 * ahead[:, None]))
    *_, suspect, _ = joint_errors(problem)
    found = numbers(problem, suspect)
    np.testing.assert_allclose(found, [0.0, 5e-4, 0.0], atol=1.5e-4)
    assert "joint joint2 has a play of" in suspect.words(found)
