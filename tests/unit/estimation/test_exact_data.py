"""Deviations of exact recordings: as large as what splines and rounding add."""

from dataclasses import replace

import numpy as np
import pytest
from random_motions import random_motion

import orbident as oi


@pytest.mark.parametrize("method", ["maximum-likelihood", "least-squares"])
@pytest.mark.parametrize(
    ("name", "rate"),
    [("paper-spatial", 5.0), ("paper-spatial", 20.0), ("cepheus-like", 100.0)],
)
def test_exact_data_are_within_their_deviations(method, name, rate):
    robot = oi.load_robot(name)
    planar = robot.motion == "planar"
    motion = random_motion(
        robot,
        seed=1,
        duration=40.0,
        start="spun up" if planar else "turning",
        wheel_speed=170.0,
    )
    recording = oi.simulate(robot, motion, rate, noise="none")
    guess = replace(robot, theta=1.1 * robot.theta)
    momentum = "at-rest" if planar else "unknown"
    result = oi.identify(guess, recording, method, momentum)
    assert not any("from outside" in words for words in result.warnings)
    beta = oi.minimal_sets(robot).beta(robot.theta)
    assert np.abs((result.base.values - beta) / result.base.std).max() <= 1
