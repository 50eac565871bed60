"""Where encoders are far noisier than sensors of the base, intervals hold.

Of so many random robots on a table as ORBIDENT_RUNS says (20 by default):

    ORBIDENT_RUNS=40 pytest -m long -s tests/statistics/test_noisy_encoders.py
"""

import os
from dataclasses import replace

import numpy as np
import pytest
from clean_recordings import RATE, SENSORS
from random_motions import random_motion
from random_robots import random_parents, random_planar_robot, random_wheels

import orbident as oi
from orbident.model.minimal_sets import minimal_sets
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.robot.sensor_schema import declared_sensors

RUNS = int(os.environ.get("ORBIDENT_RUNS", "20"))

HEAVY = 10.0
"""Times as heavy as drawn is the base, so that it turns less than the arm."""

SURE, MOST = 1.96, 5.0
"""Deviations of a 95 % interval, and more than the worst of some thousand numbers."""


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
    every, refused = [], 0
    for seed in range(RUNS):
        robot, recording = drawn(seed, noise)
        result = oi.identify(robot, recording, initial_momentum="at-rest")
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
