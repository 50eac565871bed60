"""A result that leaves its process, or is copied."""

import copy
import pickle
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import pytest
from random_motions import random_motion

from orbident.estimation.identify import Method, identify
from orbident.estimation.result import Result
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import simulate


def identified(method: Method, sign: float = 1.0) -> Result:
    robot = load_robot("paper-spatial")
    recording = simulate(robot, random_motion(robot, duration=10.0), rate=10.0, seed=1)
    turned = {"gyro.x": sign * recording.column("gyro.x")}
    return identify(robot, recording.with_columns(turned), method)


@pytest.mark.parametrize("method", ["maximum-likelihood", "least-squares"])
def test_a_pickled_result_says_the_same(method: Method):
    result = identified(method)
    again: Result = pickle.loads(pickle.dumps(result))
    assert again.to_json() == result.to_json()
    for one, other in zip(again.signals(), result.signals(), strict=True):
        assert one.name == other.name
        assert (one.predicted == other.predicted).all()
    assert copy.deepcopy(again).to_json() == result.to_json()


def test_a_refused_result_keeps_its_causes():
    result = identified("least-squares", -1.0)
    assert result.status == "rejected"
    again = pickle.loads(pickle.dumps(result.with_causes()))
    assert "the sign of x of the gyro differs" in again.refusal()


def test_nobody_looks_for_causes_unless_asked():
    result = identified("least-squares", -1.0)
    again = pickle.loads(pickle.dumps(result))
    assert again.with_causes().refusal() == result.refusal()
    assert result.with_causes("none").refusal() == result.refusal()


def test_a_pool_gives_results_back():
    with ProcessPoolExecutor(1, get_context("fork")) as pool:
        assert pool.submit(identified, "least-squares").result().status == "ok"
