"""Signs, units and orders: what undoes them, and which one the linear test finds."""

import numpy as np
import pytest
from cause_problems import clean, problem_with
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from orbident.diagnosis.conventions import Convention, conventions
from orbident.diagnosis.linear_test import (
    FALLS,
    HARDLY,
    CorrectedConvention,
    tried_conventions,
)
from orbident.estimation.momentum_problem import momentum_problem
from orbident.recordings.recording import Recording


def test_no_two_have_the_same_words():
    """But for a quarter turn, to one side and the other."""
    causes = [each.cause for each in conventions(problem_with())]
    words = [each for each in causes if "a quarter of a turn" not in each]
    assert len(words) == len(set(words))


def test_what_undoes_one_is_the_same_for_samples_and_columns():
    problem = problem_with()
    quick = [each for each in conventions(problem) if each.quickly]
    for words in ("sign of joint", "wheels", "zero of", "rpm", "is in mm"):
        each = next(one for one in quick if words in one.cause)
        again = problem.amended(recording=each.written(problem))
        for name in ("q", "qd", "w", "qd_rw", "v_S"):
            np.testing.assert_allclose(
                np.array(getattr(again.samples, name)),
                np.array(getattr(each.amended(problem), name)),
                atol=1e-3,
                err_msg=each.cause,
            )


@pytest.mark.slow
def test_nothing_is_found_where_nothing_is_wrong():
    assert tried_conventions(problem_with())[0].falls < FALLS


@pytest.mark.slow
def test_the_signs_of_two_joints():
    problem = problem_with({f"joint.joint{k}.position": lambda q: -q for k in (1, 3)})
    assert "joints joint1 and joint3" in tried_conventions(problem)[0].convention.cause
    assert clean().robot.joint_names == ("joint1", "joint2", "joint3")


@pytest.mark.slow
def test_a_zero_that_is_a_quarter_turn_away():
    problem = problem_with({"joint.joint2.position": lambda q: q - np.pi / 2})
    first = tried_conventions(problem)[0]
    assert "zero of joint joint2 is a quarter of a turn off" in first.convention.cause
    assert first.residuals_alone > FALLS


@pytest.mark.slow
def test_likelier_signs_are_no_reason_for_larger_residuals():
    """They would be 1000 times likelier, and leave residuals 10 times as large."""
    problem = problem_with({"joint.joint2.position": lambda q: np.roll(q, 1)})
    for one in tried_conventions(problem):
        assert one.falls <= FALLS or one.residuals_alone > HARDLY


@pytest.mark.slow
def test_rates_of_euler_angles():
    t, x = clean().recording.t, clean().recording.vector("attitude", "xyzw")
    yaw, pitch, roll = np.unwrap(Rotation.from_quat(x).as_euler("ZYX"), axis=0).T
    rates = (np.gradient(angle, t) for angle in (roll, pitch, yaw))
    problem = problem_with(
        {
            f"gyro.{k}": lambda _, rate=rate: rate
            for k, rate in zip("xyz", rates, strict=True)
        }
    )
    assert "Euler" in tried_conventions(problem)[0].convention.cause


def test_a_velocity_in_base_axes():
    recording = clean().recording
    t, x = recording.t, recording.vector("attitude", "xyzw")
    v = CubicSpline(t, recording.vector("position")).derivative()(t)
    v_B = Rotation.from_quat(x).inv().apply(v)
    columns = {
        name: column
        for name, column in recording.columns.items()
        if not name.startswith("position")
    }
    columns |= {f"velocity.{k}": v_B[:, i].copy() for i, k in enumerate("xyz")}
    shown = Recording(t, columns)
    problem = momentum_problem(clean().robot, shown, "unknown", lambda _: None)
    cause = tried_conventions(problem)[0].convention.cause
    assert cause == "the velocity is in base axes, not in inertial ones"


def test_two_that_look_the_same_are_both_named():
    def one(cause: str, falls: float) -> CorrectedConvention:
        written = Convention(cause, lambda problem: problem.recording)
        return CorrectedConvention(written, falls, falls, as_cad=False)

    first, worse, alike = one("a differs", 46.1), one("b differs", 3.0), one("c", 46.1)
    assert first.or_one_of([worse, alike]).convention.cause == "a differs, or c"
    assert first.or_one_of([worse, first]) == first
