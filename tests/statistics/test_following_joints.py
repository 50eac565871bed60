"""Joints that follow others, on robots drawn at random: intervals hold.

Of so many robots as ORBIDENT_RUNS says (20 by default), some without a column of the
follower:

    ORBIDENT_RUNS=80 pytest -m long -s tests/statistics/test_following_joints.py
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
from orbident.robot.description import Coupling, Robot
from orbident.robot.sensor_schema import declared_sensors

RUNS = int(os.environ.get("ORBIDENT_RUNS", "20"))

FACTORS = (-1.0, 1.0, 0.5, 3.0, -3.0, 10.0, 40.0, -100.0)

TURNS = 3.0
"""A follower turns so many times as far as other joints, at most some."""

LIGHT = 0.2
"""Over its factor: how heavy what turns fast is, beside what does not."""


def drawn(seed: int) -> tuple[Robot, Recording]:
    random = np.random.default_rng(seed)
    joints = int(random.integers(3, 5))
    wheels = random_wheels(seed, ["held", "held", "held"])
    robot = random_robot(seed, random_parents(random, joints), (), wheels, base=20.0)
    factor = float(random.choice(FACTORS))
    leader, follower = random.permutation(joints)[:2]
    names, theta = robot.joint_names, robot.theta.copy()
    if abs(factor) > 1:
        theta[follower + 1] *= LIGHT / abs(factor)
    robot = replace(
        robot,
        theta=theta,
        joints=tuple(replace(each, position=None) for each in robot.joints),
        couplings=(Coupling(names[follower], names[leader], factor, 0.0),),
        sensors=declared_sensors({"rate": RATE, **SENSORS}),
    )
    motion = random_motion(robot, seed, 60.0, start="turning")
    led = [k for k in range(joints) if k != follower]
    slower = max(1.0, abs(factor) / TURNS)
    motion = replace(
        motion,
        joints=tuple(names[k] for k in led),
        a=motion.a[led] / slower,
        b=motion.b[led] / slower,
        start=motion.start[led],
        end=motion.end[led],
    )
    recording = oi.simulate(robot, motion, noise="sensors", seed=seed)
    if random.random() < 0.5:
        own = f"joint.{names[follower]}."
        columns = {k: x for k, x in recording.columns.items() if not k.startswith(own)}
        recording = replace(recording, columns=columns)
    return robot, recording


@pytest.mark.long
def test_intervals_hold_where_joints_follow_others():
    assert_intervals_hold(map(drawn, range(RUNS)), refused=0.05)
