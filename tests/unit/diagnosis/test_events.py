"""A recording that is good until something happens."""

import numpy as np
import pytest
from cause_problems import clean, problem_with

from orbident.diagnosis.events import event


@pytest.mark.slow
def test_a_position_that_drifts_from_the_middle_on():
    later = np.maximum(np.arange(301) - 150, 0)
    happened = event(problem_with({"position.y": lambda x: x + 1e-3 * later[: x.size]}))
    assert happened is not None
    assert "the position and the other instruments do not agree" in happened.fact
    assert "between t = " in happened.fact


def test_joints_of_the_other_sign_disagree_with_everything():
    names = clean().robot.joint_names
    wrong = {f"joint.{name}.position": lambda q: -q for name in names}
    assert event(problem_with(wrong)) is None
