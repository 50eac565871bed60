"""Wheels that lose speed unseen are no torque, and deviations hold what they lose."""

import numpy as np
import pytest
from recordings import SPACE, clean
from wrong_motions import spun_down

from orbident.estimation.identify import identify
from orbident.model.minimal_sets import minimal_sets

BEYOND = 5.0
"""Deviations that no accepted parameter is off by."""


@pytest.mark.parametrize("part", [0.0005, 0.001, 0.003, 0.007])
def test_nothing_accepted_is_wrong(part: float):
    flown = clean(SPACE)
    spoiled = spun_down(part)(flown)
    result = identify(spoiled.robot, spoiled.recording)
    assert result.status == "ok"
    off = result.base.values - minimal_sets(flown.robot).beta(flown.robot.theta)
    assert np.abs(off / result.base.std).max() < BEYOND
    assert any("slows down unseen" in words for words in result.warnings)
