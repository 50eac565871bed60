"""What a result finds out later runs like the verb that gave it."""

import pytest
from random_motions import random_motion
from threadpoolctl import threadpool_info, threadpool_limits

from orbident.diagnosis import causes as module
from orbident.estimation.identify import identify
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate


def blas_threads() -> set[int]:
    return {
        pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"
    }


def test_causes_are_searched_for_with_one_blas_thread(monkeypatch: pytest.MonkeyPatch):
    """With as many threads as processors a search took ten times as long."""
    used = list[set[int]]()

    def causes(*_: object) -> list[object]:
        used.append(blas_threads())
        return []

    monkeypatch.setattr(module, "_causes", causes)
    robot = load_robot("paper-spatial")
    recording = simulate(robot, random_motion(robot, wheel_speed=0.0))
    with threadpool_limits(limits=2, user_api="blas"):
        result = identify(robot, recording, "least-squares")
        assert result.status == "rejected"
        result.with_causes()
        assert 2 in blas_threads()
    assert used == [{1}]
