"""Where a joint moves by little more than its encoder's noise, intervals hold.

Of so many random robots as ORBIDENT_RUNS says (20 by default):

    ORBIDENT_RUNS=40 pytest -m long -s tests/statistics/test_joints_that_hardly_move.py
"""

import os
from dataclasses import replace

import numpy as np
import pytest
from clean_recordings import RATE, SENSORS
from random_motions import random_motion
from random_robots import random_parents, random_robot, random_wheels

import orbident as oi
from orbident.model.minimal_sets import minimal_sets
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.sensor_schema import declared_sensors

RUNS = int(os.environ.get("ORBIDENT_RUNS", "20"))

NOISE = 1e-3
"""rad, of encoders: forty times that of the paper's."""

SURE, MOST = 1.96, 5.0
"""Deviations of a 95 % interval, and more than the worst of some thousand numbers."""


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
    every, refused = [], 0
    for seed in range(RUNS):
        robot, recording = drawn(seed, times)
        result = oi.identify(robot, recording)
        if result.status != "ok":
            refused += 1
            print(seed, result.refusal(), flush=True)
            continue
        off = result.base.values - minimal_sets(robot).beta(robot.theta)
        every.append(np.abs(off / result.base.std))
        print(seed, f"{np.nanmax(every[-1]):.1f}", flush=True)
    found = np.concatenate(every)
    found = found[np.isfinite(found)]
    inside = np.mean(found < SURE)
    print(f"{RUNS - refused} of {RUNS} accepted, {inside:.1%} of {found.size} inside,")
    print(f"worst {found.max():.1f}")
    assert refused <= RUNS / 10
    assert inside > 0.91
    assert found.max() < MOST
