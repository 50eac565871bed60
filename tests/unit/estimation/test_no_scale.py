"""In the plane, a wheel that turns steadily tells no scale, and noise of it neither.

A momentum that is known does (Eq. 24).
"""

from dataclasses import replace

import numpy as np
import pytest
from random_motions import random_motion
from random_robots import random_planar_robot

import orbident as oi
from orbident.estimation.linear_fits import InitialMomentum
from orbident.estimation.momentum_problem import momentum_problem
from orbident.robot.description import Wheel
from orbident.robot.sensor_schema import declared_sensors

SENSORS = {
    "rate": 20,
    "attitude": {"angle": 3e-4},
    "position": {"std": 1e-4},
    "joints": {"position": 1e-4},
    "wheels": {"tachometer": 0.1},
}
"""The tachometer's noise is small beside a speed of 200 rad/s, and smoothed it is as
slow as the arm."""


def scale_seen(seed: int, momentum: InitialMomentum) -> bool:
    """Whether 80 s of a random robot on a table, with noise, show a scale."""
    wheel = Wheel("rw", np.array([0.0, 0.0, 1.0]), 0.05)
    robot = replace(
        random_planar_robot(seed, (0, 1), wheels=[wheel]),
        sensors=declared_sensors(SENSORS),
    )
    motion = random_motion(robot, seed, duration=80.0, start="spun up")
    slower = 0.1 ** np.arange(motion.a.shape[1])
    motion = replace(motion, a=slower * motion.a, b=slower * motion.b)
    recording = oi.simulate(robot, motion, noise="sensors", seed=seed)
    return momentum_problem(robot, recording, momentum, lambda _: None).scale_seen


@pytest.mark.slow
def test_noise_of_a_steady_wheel_is_no_scale():
    assert not any(scale_seen(seed, "unknown") for seed in range(8))


def test_a_known_momentum_is_one():
    assert all(scale_seen(seed, "at-rest") for seed in range(8))
