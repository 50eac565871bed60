"""When a robot changed while it was recorded, by the linear equations alone."""

from dataclasses import replace

import numpy as np
import pytest
from captured_bodies import (
    CapturedBody,
    holding,
    simulate_change,
    truth_through_changes,
)
from clean_recordings import RATE, clean_space
from random_motions import random_motion

from orbident.estimation.changes import changes_of, left_by_two, shows_a_robot
from orbident.estimation.momentum_problem import MomentumProblem, momentum_problem
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.simulation.measure import measure_truth
from orbident.simulation.simulate import sample_times

# What is captured need not keep to what is known of a link.
ROBOT = replace(clean_space(seed=1, duration=10.0).robot, structure={})
EDGES = np.array([0, 30, 50, 90])
LOAD = CapturedBody(50.0, np.array([0.1, 0.2, 0.1]), 5.0 * np.eye(3))


def changed(at: float, before: Robot, after: Robot, seed: int = 2) -> Recording:
    motion = random_motion(
        ROBOT, seed=seed, duration=40.0, wheel_speed=100.0, start="turning"
    )
    return simulate_change(before, after, motion, at, seed)


def problem_of(recording: Recording) -> MomentumProblem:
    return momentum_problem(ROBOT, recording, "unknown", lambda _: None)


@pytest.fixture(scope="module")
def captured() -> MomentumProblem:
    return problem_of(changed(13.05, ROBOT, holding(ROBOT, LOAD)))


def test_what_two_robots_leave_as_least_squares_has_it():
    """The plain version: two fits for every edge."""
    random = np.random.default_rng(1)
    every = [random.normal(size=(90, axes, 5)) for axes in (3, 2)]

    def squares(rows: np.ndarray) -> float:
        A, b = rows[..., :-1].reshape(-1, 4), rows[..., -1].ravel()
        return float(np.sum((b - A @ np.linalg.lstsq(A, b)[0]) ** 2))

    for edge, found in zip((30, 50), left_by_two(every, EDGES)[1:-1], strict=True):
        two = [squares(rows[:edge]) + squares(rows[edge:]) for rows in every]
        one = [squares(rows) for rows in every]
        assert found == pytest.approx(np.prod(two) / np.prod(one))


def test_a_capture(captured):
    (change,) = changes_of(captured)
    assert 12.0 < change.onset < 13.05 < change.t < 14.5
    assert change.statistic > 1
    assert change.confidence == pytest.approx(1.0)


def test_a_capture_and_a_release():
    both = holding(ROBOT, LOAD)
    motion = random_motion(
        ROBOT, seed=2, duration=60.0, wheel_speed=100.0, start="turning"
    )
    t = sample_times(motion.duration, RATE)
    true = truth_through_changes([ROBOT, both, ROBOT], motion, [18.05, 41.05], t)
    found = changes_of(problem_of(measure_truth(ROBOT, t, true, seed=1)))
    for each, at in zip(found, (18.05, 41.05), strict=True):
        assert at - 2.0 < each.onset < at < each.t < at + 2.0


@pytest.mark.parametrize("duration", [15.0, 40.0])
def test_one_robot_does_not_change(duration):
    recording = clean_space(seed=3, duration=duration).recording
    assert changes_of(problem_of(recording)) == ()


@pytest.mark.parametrize(("changes", "shown"), [(1e-5, False), (1e-2, True)])
def test_wheels_of_one_speed_show_no_robot_on_a_table(changes: float, shown: bool):
    """A constant momentum balances theirs: parameters of zero solve Eq. 24."""
    random = np.random.default_rng(2)
    rows = random.normal(size=(50, 1, 4))
    rows[..., 0] = -1.0
    rows[..., -1] = 0.3 * (1 + changes * random.normal(size=(50, 1)))
    assert shows_a_robot(rows) is shown
