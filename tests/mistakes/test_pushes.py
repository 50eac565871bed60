"""A short push is identified with the parameters; a capture is not taken for one."""

import numpy as np
import pytest
from recordings import SPACE, TABLE, clean
from scipy.spatial.transform import Rotation
from spoiled import Spoiled
from wrong_columns import columns
from wrong_motions import burst, changing

from orbident.estimation.identify import Method, identify
from orbident.estimation.result import Result
from orbident.model.minimal_sets import minimal_sets
from orbident.recordings.recording import Recording

AT, FOR = 10.0, 0.2
"""s."""


def identified(spoiled: Spoiled, method: Method = "maximum-likelihood") -> Result:
    return identify(
        spoiled.robot,
        spoiled.recording,
        method,
        initial_momentum=spoiled.initial_momentum,
    )


def turned(recording: Recording) -> float:
    """By how much the base turned while it was pushed, rad."""
    rows = np.searchsorted(recording.t, [AT, AT + FOR])
    before, after = Rotation.from_quat(recording.vector("attitude", "xyzw")[rows])
    return float((before.inv() * after).magnitude())


@pytest.mark.parametrize("name", [pytest.param(SPACE, marks=pytest.mark.slow), TABLE])
def test_a_burst_is_identified(name: str):
    spoiled = burst(1.0, AT, FOR)(clean(name))
    result = identified(spoiled)
    robot = clean(name).robot
    assert result.status == "ok"
    off = result.base.values - minimal_sets(robot).beta(robot.theta)
    assert np.max(np.abs(off) / result.base.std) < 4
    faster = [fit for fit in result.disturbances.values() if fit.unit == "m/s"]
    means = faster[: len(faster) // 2]
    speed = np.linalg.norm([fit.value for fit in means])
    std = np.linalg.norm([fit.value * fit.std for fit in means]) / speed
    # The force turns with the base.
    along = np.sinc(turned(spoiled.recording) / (2 * np.pi))
    assert abs(speed - 1.0 * FOR * along / robot.mass) < 4 * std
    (words,) = (words for words in result.warnings if "something pushed" in words)
    assert "with care" in {check.level for check in result.checks}
    begin, end = (float(words.split()[k]) for k in (5, 7))
    assert begin < AT < AT + FOR < end


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "method"),
    [
        pytest.param(SPACE, "structured", marks=pytest.mark.long),
        (SPACE, "recursive"),
        (TABLE, "least-squares"),
    ],
)
def test_other_methods_leave_the_burst_out(name: str, method: Method):
    result = identified(burst(1.0, AT, FOR)(clean(name)), method)
    assert result.status == "ok", result.warnings
    robot = clean(name).robot
    off = result.base.values - minimal_sets(robot).beta(robot.theta)
    assert np.max(np.abs(off) / result.base.std) < 5


@pytest.mark.slow
@pytest.mark.parametrize("name", [SPACE, TABLE])
def test_a_capture_is_no_push(name: str):
    assert identified(changing(-1, 0.3)(clean(name))).status == "rejected"


def test_a_joint_that_slips_is_no_push():
    """What explains the momenta after it would hide what the encoder shows."""
    slipped = columns("joint.joint2.position", lambda q: q + 0.03 * later(q))(
        clean(TABLE)
    )
    assert identified(slipped).status == "rejected"


def later(x: np.ndarray) -> np.ndarray:
    """1 in the second half of the recording."""
    return np.arange(x.size) >= x.size // 2
