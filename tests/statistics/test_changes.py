"""Captures are found at once, nothing is found where nothing happens, and what the
filter says of its own error is true.

A few runs here; `ORBIDENT_RUNS=50` (captures; four times as many clean ones) for the
figures of the issue.
"""

import os
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from captured_bodies import CapturedBody, holding, truth_through_change

from orbident.estimation.estimate import History
from orbident.estimation.recursive.history import recursive_history
from orbident.model.minimal_sets import minimal_sets
from orbident.preprocessing.samples import samples_of
from orbident.robot.description import Robot
from orbident.simulation.free_floating import FreeFloating
from orbident.simulation.measure import measure_truth, truth_of
from orbident.simulation.simulate import float_along, sample_times
from orbident.studies.paper_tables import spatial_robot, spatial_trajectory

RUNS = int(os.environ.get("ORBIDENT_RUNS", "1"))
CAPTURE = 40.0
RATE = 20.0
TARGET = CapturedBody(50.0, np.array([1.0, 0.0, 0.0]), 4.0 * np.eye(3))


def cad(robot: Robot, seed: int) -> Robot:
    """Every nominal parameter up to 20 % off."""
    random = np.random.default_rng(seed)
    return replace(
        robot, theta=robot.theta * (1 + random.uniform(-0.2, 0.2, robot.theta.shape))
    )


def error(history: History, theta: np.ndarray, robot: Robot) -> float:
    """Normalised estimation error squared of `beta`, per degree of freedom."""
    d = history.beta[-1] - minimal_sets(robot).beta(theta)
    return float(d @ np.linalg.solve(history.covariance, d)) / d.size


class Scene(NamedTuple):
    robot: Robot
    motion: FreeFloating


@pytest.fixture(scope="module")
def scene() -> Scene:
    robot = spatial_robot()
    return Scene(robot, float_along(robot, spatial_trajectory(robot), RATE))


def test_nothing_is_found_where_nothing_happens(scene: Scene):
    """And `beta` is as wrong as its covariance says: a mean of one, and for the mean
    of n runs of 18 degrees of freedom a standard deviation of sqrt(2/18n)."""
    robot, motion = scene
    true = truth_of(robot, motion, spatial_trajectory(robot))
    runs, errors = 4 * RUNS, []
    for seed in range(runs):
        table = measure_truth(robot, motion.t, true, seed)
        history = recursive_history(cad(robot, seed), samples_of(robot, table))
        assert history.changes == ()
        assert history.determined.all()
        errors.append(error(history, robot.theta, robot))
    print(f"{runs} clean runs: mean error squared {np.mean(errors):.3f}")
    # Joint rates are no white noise, and count for more than they are.
    spread = 4 * np.sqrt(2 / 18 / runs)
    assert 0.7 - spread < np.mean(errors) < 1.0 + spread


def test_a_capture_is_found_at_once(scene: Scene):
    robot, _ = scene
    after = holding(robot, TARGET)
    t = sample_times(80.0, RATE)
    true = truth_through_change(robot, after, spatial_trajectory(robot), CAPTURE, t)
    delays, again = [], 0
    for seed in range(RUNS):
        samples = samples_of(robot, measure_truth(robot, t, true, seed))
        history = recursive_history(cad(robot, seed), samples)
        change = history.changes[0]
        delays.append(change.t - CAPTURE)
        assert 0.0 <= delays[-1] < 5.0
        again += len(history.changes) > 1
        assert change.onset == pytest.approx(CAPTURE, abs=0.5)
        # Forty seconds after, the heavier robot is known.
        assert abs(history.M[-1] - after.mass) < 5 * history.std[-1, 0]
    # While the heavier robot is being learnt from values 30 % off, one run in fifty
    # (seed 43) raises a second alarm, nine seconds later: no false alarm is promised
    # for a robot that is not known yet.
    assert again <= RUNS // 25
    print(
        f"{RUNS} captures, {again} with a second alarm: worst delay {max(delays):.2f} s"
    )
