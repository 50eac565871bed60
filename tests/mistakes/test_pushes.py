"""A short push is identified with the parameters; a capture is not taken for one."""

import numpy as np
import pytest
from recordings import SPACE, TABLE, clean
from spoiled import Spoil
from wrong_motions import burst, changing

from orbident.estimation.identify import identify
from orbident.estimation.result import Result
from orbident.model.minimal_sets import minimal_sets

AT = 10.0
"""s."""


def identified(name: str, spoil: Spoil) -> Result:
    spoiled = spoil(clean(name))
    return identify(
        spoiled.robot, spoiled.recording, initial_momentum=spoiled.initial_momentum
    )


@pytest.mark.parametrize("name", [SPACE, TABLE])
def test_a_burst_is_identified(name: str):
    result = identified(name, burst(1.0, AT, 0.2))
    robot = clean(name).robot
    assert result.status == "ok"
    off = result.base.values - minimal_sets(robot).beta(robot.theta)
    assert np.max(np.abs(off) / result.base.std) < 4
    faster = [fit for fit in result.disturbances.values() if fit.unit == "m/s"]
    means = faster[: len(faster) // 2]
    speed = np.linalg.norm([fit.value for fit in means])
    std = np.linalg.norm([fit.value * fit.std for fit in means]) / speed
    assert abs(speed - 1.0 * 0.2 / robot.mass) < 4 * std
    (words,) = (words for words in result.warnings if "something pushed" in words)
    assert "with care" in {check.level for check in result.checks}
    begin, end = (float(words.split()[k]) for k in (5, 7))
    assert begin < AT < AT + 0.2 < end


@pytest.mark.parametrize("name", [SPACE, TABLE])
def test_a_capture_is_no_push(name: str):
    assert identified(name, changing(-1, 0.3)).status == "rejected"
