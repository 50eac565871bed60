"""A recording that is good until something happens."""

import numpy as np
from cause_problems import problem_with

from orbident.diagnosis.events import event


def test_a_position_that_drifts_from_the_middle_on():
    later = np.maximum(np.arange(301) - 150, 0)
    happened = event(problem_with({"position.y": lambda x: x + 1e-3 * later[: x.size]}))
    assert happened is not None
    assert "the position drifts, or has a jump" in happened.reason


def test_no_part_of_a_recording_with_a_wrong_sign():
    assert event(problem_with({"gyro.x": lambda w: -w})) is None
