"""Intervals where the noise of motion capture lasts, declared and not."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from random_motions import random_motion

from orbident.estimation.identify import Method, identify
from orbident.excitation.bound import bound_of
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.robot.sensor_schema import declared_sensors
from orbident.simulation.simulate import simulate

slow = partial(pytest.param, marks=pytest.mark.slow)

WHITE = {
    "rate": 50.0,
    "joints": {"position": 2e-5},
    "wheels": {"tachometer": 1e-3},
    "attitude": {"angle": 6.1e-5},
    "position": {"std": 8.3e-6},
}
LASTS = {
    **WHITE,
    "attitude": {"angle": 6.1e-5, "markov_std": 2.5e-5, "correlation_time": 0.07},
    "position": {
        "std": 8.3e-6,
        "markov_std": 2e-5,
        "correlation_time": 0.5,
        "random_walk": 3e-6,
    },
}
"""About what the motion capture of the real Cepheus has at rest."""


def robot_with(sensors) -> Robot:
    return replace(load_robot("cepheus-like"), sensors=declared_sensors(sensors))


def off(
    robot: Robot, recording, method: Method = "maximum-likelihood"
) -> tuple[str, np.ndarray]:
    """The level, and errors of the base parameters over their deviations."""
    result = identify(robot, recording, method, "at-rest")
    found = result.diagnostics or result
    true = minimal_sets(robot).beta(robot.theta)
    std = np.sqrt(np.diag(found.base_covariance))
    return result.level, (found.base.values - true) / std


def flight(seed: int):
    robot = robot_with(LASTS)
    motion = random_motion(robot, seed, 20.0, start="spun up")
    return simulate(robot, motion, noise="sensors", seed=seed)


@pytest.mark.slow
def test_what_lasts_is_refused_if_it_is_taken_as_white():
    recording = flight(0)
    level, errors = off(robot_with(LASTS), recording)
    assert level == "trust"
    assert np.abs(errors).max() < 4
    level, _ = off(robot_with(WHITE), recording)
    assert level == "do not trust"


@pytest.mark.parametrize("seed", [slow(1), 2, slow(3)])
def test_the_filter_takes_what_lasts_into_account(seed: int):
    """It sees no change of the robot in it, and its intervals hold."""
    robot, recording = robot_with(LASTS), flight(seed)
    level, errors = off(robot, recording, "recursive")
    assert level == "trust"
    assert np.abs(errors).max() < 4
    by_filter = identify(robot, recording, "recursive", "at-rest").base.std
    best = identify(robot, recording, "maximum-likelihood", "at-rest").base.std
    # No estimate is better than the best one; noise that lasts is not modelled exactly.
    assert (by_filter >= 0.999 * best).all()
    assert (by_filter < 3 * best).all()


def test_deviations_are_those_of_the_bound():
    robot = robot_with(LASTS)
    motion = random_motion(robot, 1, 20.0, start="spun up")
    bound, white = (
        np.sqrt(np.diag(bound_of(each, motion, "at-rest").parameters.base.covariance))
        for each in (robot, robot_with(WHITE))
    )
    found = identify(robot, flight(1), initial_momentum="at-rest")
    # At the estimate, and at the truth.
    std = np.sqrt(np.diag(found.base_covariance))
    np.testing.assert_allclose(std, bound, rtol=0.1)
    assert (bound > white).all()


@pytest.mark.long
def test_intervals_hold_what_is_true():
    """Pooled over 1200 flights of 8 parameters."""
    errors = np.array([off(robot_with(LASTS), flight(seed))[1] for seed in range(1200)])
    inside = np.mean(np.abs(errors) < 1.96)
    # The parameters of a flight are correlated: as 2.5 independent ones, chance is
    # 0.4 % of the cases, and 1.3 % of the size.
    assert 0.94 < inside < 0.96
    assert np.sqrt(np.mean(errors**2)) == pytest.approx(1.0, abs=0.04)
