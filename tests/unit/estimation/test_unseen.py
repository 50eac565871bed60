"""What may act unseen calls for care, unless the robot file says what acts."""

from dataclasses import replace

import pytest
from random_motions import random_motion

from orbident.estimation.checks import Check
from orbident.estimation.identify import identify
from orbident.estimation.result import Result
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate


@pytest.fixture(scope="module")
def results() -> dict[str, Result]:
    """A good recording on a table, by what the robot file says of it."""
    robot = load_robot("cepheus-like")
    motion = random_motion(robot, 1, 20.0, start="spun up")
    recording = simulate(robot, motion, noise="sensors", seed=1)
    said = {"silent": None, "nothing acts": (), "it may act": ("slow_torque",)}
    return {
        name: identify(
            replace(robot, disturbances=acts), recording, initial_momentum="at-rest"
        )
        for name, acts in said.items()
    }


def unseen(result: Result) -> list[Check]:
    return [check for check in result.checks if check.name == "unseen"]


def test_a_silent_robot_file_calls_for_care(results: dict[str, Result]):
    silent = results["silent"]
    (check,) = unseen(silent)
    assert silent.level == check.level == "with care"
    assert "a torque acts that changes slowly" in check.reason
    assert "--disturbance slow_torque" in check.remedy
    assert "disturbances: []" in check.remedy
    table = silent.sensitivity()
    assert table is not None
    shifts = table.shifts[:, [name == "slow_torque" for name in table.errors]]
    assert check.statistic == pytest.approx(shifts.max(), rel=1e-6)


def test_who_knows_that_nothing_acts_may_trust(results: dict[str, Result]):
    assert results["nothing acts"].level == "trust"
    assert not unseen(results["nothing acts"])


def test_what_is_said_to_act_is_in_the_deviations(results: dict[str, Result]):
    """That is what the check warned of: the deviations are many times as wide."""
    silent, known = results["silent"], results["it may act"]
    assert known.level == "trust"
    wider = (known.base.std / silent.base.std).max()
    assert 5.0 < wider < unseen(silent)[0].statistic
