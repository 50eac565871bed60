"""Where encoders are far noisier than sensors of the base, intervals hold.

Of so many random robots on a table as ORBIDENT_RUNS says (20 by default):

    ORBIDENT_RUNS=40 pytest -m long -s tests/statistics/test_noisy_encoders.py
"""

import os
from dataclasses import replace

import numpy as np
import pytest
from clean_recordings import RATE, SENSORS
from interval_statistics import assert_intervals_hold
from random_motions import random_motion
from random_robots import random_parents, random_planar_robot, random_wheels

import orbident as oi
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.sensor_schema import declared_sensors

RUNS = int(os.environ.get("ORBIDENT_RUNS", "20"))

HEAVY = 10.0
"""Times as heavy as drawn is the base, so that it turns less than the arm."""


def drawn(seed: int, noise: float) -> tuple[Robot, Recording]:
    """Spun up from rest by one wheel; encoders are so noisy, rad."""
    random = np.random.default_rng(seed)
    (wheel,) = random_wheels(seed, ["held"])
    wheel = replace(wheel, axis=np.array([0.0, 0.0, 1.0]))
    parents = random_parents(random, int(random.integers(2, 4)))
    robot = random_planar_robot(seed, parents, (), (wheel,))
    theta = robot.theta.copy()
    theta[0] *= HEAVY
    robot = replace(
        robot,
        theta=theta,
        joints=tuple(replace(each, position=None) for each in robot.joints),
        sensors=declared_sensors(
            {"rate": RATE, **SENSORS, "joints": {"position": noise}}
        ),
    )
    motion = random_motion(robot, seed, 60.0, start="spun up")
    return robot, oi.simulate(robot, motion, noise="sensors", seed=seed)


@pytest.mark.long
@pytest.mark.parametrize("noise", [2.5e-5, 1e-3, 5e-3])
def test_intervals_hold(noise: float):
    flights = (drawn(seed, noise) for seed in range(RUNS))
    assert_intervals_hold(flights, refused=0.1, initial_momentum="at-rest")
