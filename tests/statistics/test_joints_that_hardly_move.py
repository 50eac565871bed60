"""Where a joint moves by little more than its encoder's noise, intervals hold.

Of so many random robots as ORBIDENT_RUNS says (20 by default):

    ORBIDENT_RUNS=40 pytest -m long -s tests/statistics/test_joints_that_hardly_move.py
"""

import os
from dataclasses import replace

import numpy as np
import pytest
from clean_recordings import RATE, SENSORS
from interval_statistics import assert_intervals_hold
from random_motions import random_motion
from random_robots import random_parents, random_robot, random_wheels

import orbident as oi
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.sensor_schema import declared_sensors

RUNS = int(os.environ.get("ORBIDENT_RUNS", "20"))

NOISE = 1e-3
"""rad, of encoders: forty times that of the paper's."""


def drawn(seed: int, times: float) -> tuple[Robot, Recording]:
    """One of its joints moves by so many times the noise of its encoder."""
    random = np.random.default_rng(seed)
    joints = int(random.integers(2, 5))
    wheels = random_wheels(seed, ["held", "held", "held"])
    robot = random_robot(seed, random_parents(random, joints), (), wheels, base=20.0)
    robot = replace(
        robot,
        joints=tuple(replace(each, position=None) for each in robot.joints),
        sensors=declared_sensors(
            {"rate": RATE, **SENSORS, "joints": {"position": NOISE}}
        ),
    )
    motion = random_motion(robot, seed, 60.0, start="turning")
    slow = np.ones((joints, 1))
    which = int(random.integers(joints))
    size = np.hypot(motion.a[which], motion.b[which]).sum()
    slow[which] = times * NOISE / size
    motion = replace(motion, a=slow * motion.a, b=slow * motion.b)
    return robot, oi.simulate(robot, motion, noise="sensors", seed=seed)


@pytest.mark.long
@pytest.mark.parametrize("times", [0.3, 1.0, 3.0, 10.0])
def test_intervals_hold(times: float):
    flights = (drawn(seed, times) for seed in range(RUNS))
    assert_intervals_hold(flights, refused=0.1)
