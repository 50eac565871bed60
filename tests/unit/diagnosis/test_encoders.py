"""Encoders whose error has a course, and joints that give way."""

import numpy as np
import pytest
from cause_problems import clean, fitted, numbers, problem_with, with_recording

from orbident.diagnosis.encoders import joint_errors, ripples
from orbident.diagnosis.shifts import less
from orbident.model.equations_of_motion import equations_of_motion
from orbident.model.kinematics import carried_inertia


@pytest.mark.slow
def test_joints_that_give_way():
    """`q_m = q + tau / (I (2 pi f)^2)`: the torques of a base that nothing holds."""
    robot, samples = clean().robot, problem_with().samples
    moved = np.vstack([samples.w, samples.qd, samples.qd_rw])
    none = np.zeros((3, samples.t.size))
    v, v_dot = (
        np.vstack([none, x]).T for x in (moved, np.gradient(moved, samples.t, axis=1))
    )
    H, c, _ = equations_of_motion(robot, np.array(samples.q).T, v)
    own = v_dot[:, 6:, None]
    base = -np.linalg.solve(H[:, :6, :6], H[:, :6, 6:] @ own + c[:, :6, None])
    tau = (H[:, 6:, :6] @ base + H[:, 6:, 6:] @ own)[..., 0] + c[:, 6:]
    soft, recording = 1 / (2 * np.pi * 2.0) ** 2, clean().recording
    for k, name in enumerate(robot.joint_names):
        bent = soft * tau[:, k] / (carried_inertia(robot, k) @ robot.theta.ravel())
        recording = less(recording, f"joint.{name}", -bent[:, None])
    problem = with_recording(recording)
    *_, suspect = joint_errors(problem, fitted(problem))
    found = numbers(problem, suspect)
    # Differences over 0.1 s, and joints that smoothing has made a little slower.
    np.testing.assert_allclose(found, soft, rtol=0.3)
    assert "gives way" in suspect.words(found)


@pytest.mark.slow
def test_an_encoder_that_drifts():
    recording = clean().recording
    elapsed = (recording.t - recording.t[0]) / (recording.t[-1] - recording.t[0])
    wrong = less(recording, "joint.joint2", -5e-3 * elapsed[:, None])
    problem = with_recording(wrong)
    suspect, *_ = joint_errors(problem, fitted(problem))
    found = numbers(problem, suspect)
    np.testing.assert_allclose(found, [0.0, 5e-3, 0.0], atol=5e-4)
    assert "joint joint2: its position drifts" in suspect.words(found)


def test_an_encoder_off_the_centre_of_its_axis():
    recording = clean().recording
    q = recording.columns["joint.joint2.position"]
    wrong = less(recording, "joint.joint2", -5e-3 * np.sin(q)[:, None])
    problem = with_recording(wrong)
    _, suspect, *_ = joint_errors(problem, fitted(problem))
    found = numbers(problem, suspect)
    np.testing.assert_allclose(found[2:4], [5e-3, 0.0], atol=5e-4)
    assert "the encoder of joint joint2 is off the centre" in suspect.words(found)


@pytest.mark.slow
def test_a_gear_with_play():
    """The motor is ahead of the link by half of it, on the side to which it turns."""
    recording = clean().recording
    q = recording.columns["joint.joint2.position"]
    ahead = np.sign(np.gradient(q, recording.t))
    problem = with_recording(less(recording, "joint.joint2", -5e-4 * ahead[:, None]))
    *_, suspect, _ = joint_errors(problem, fitted(problem))
    found = numbers(problem, suspect)
    np.testing.assert_allclose(found, [0.0, 5e-4, 0.0], atol=1.5e-4)
    assert "joint joint2 has a play of" in suspect.words(found)


@pytest.mark.parametrize("a_turn", [pytest.param(60.0, marks=pytest.mark.slow), 200.0])
def test_a_gear_whose_teeth_show(a_turn: float):
    recording = clean().recording
    q = recording.columns["joint.joint2.position"]
    wrong = less(recording, "joint.joint2", -1e-3 * np.sin(a_turn * q)[:, None])
    problem = with_recording(wrong)
    (suspect,) = ripples(problem, fitted(problem))
    found = numbers(problem, suspect)
    assert np.linalg.norm(found) == pytest.approx(1e-3, rel=0.1)
    assert "the encoder of joint joint2 has a ripple of" in suspect.words(found)
    assert f"{a_turn:.3g} times a turn" in suspect.words(found)


def test_smooth_encoders_have_no_ripple():
    problem = problem_with()
    assert [*ripples(problem, fitted(problem))] == []
