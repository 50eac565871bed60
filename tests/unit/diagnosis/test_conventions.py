"""Signs, units and orders: what undoes them, and which one the linear test finds."""

import numpy as np
from cause_problems import clean, problem_with

from orbident.diagnosis.conventions import conventions
from orbident.diagnosis.linear_test import FALLS, tried_conventions


def test_no_two_have_the_same_words():
    words = [each.cause for each in conventions(problem_with())]
    assert len(words) == len(set(words))


def test_what_undoes_one_is_the_same_for_samples_and_columns():
    problem = problem_with()
    of_columns = [each for each in conventions(problem) if each.columns]
    for each in (of_columns[0], of_columns[-1]):
        again = problem.amended(recording=each.recording(problem.recording))
        for name in ("q", "qd", "qd_rw"):
            np.testing.assert_allclose(
                np.array(getattr(again.samples, name)),
                np.array(getattr(each.amended(problem), name)),
                atol=1e-3,
                err_msg=each.cause,
            )


def test_nothing_is_found_where_nothing_is_wrong():
    assert tried_conventions(problem_with())[0].falls < FALLS


def test_the_signs_of_two_joints():
    problem = problem_with({f"joint.joint{k}.position": lambda q: -q for k in (1, 3)})
    assert "joints joint1 and joint3" in tried_conventions(problem)[0].convention.cause
    assert clean().robot.joint_names == ("joint1", "joint2", "joint3")
