"""Output-error problems of a small planar robot, from a recording to its equations."""

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from random_motions import random_motion
from random_robots import random_planar_robot, random_robot, random_wheels
from scipy.spatial.transform import Rotation

from orbident.environment.motion import RobotMotion
from orbident.estimation.output_error.beforehand import prior_of
from orbident.estimation.output_error.problem import (
    NOTHING,
    Problem,
    problem_of,
    start_of,
)
from orbident.estimation.output_error.sensors import sensors_of
from orbident.estimation.solution import Prior, Unknowns
from orbident.model.minimal_sets import minimal_sets
from orbident.preprocessing.delays import SENSORS
from orbident.preprocessing.samples import samples_of
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot, Wheel
from orbident.robot.may_act import MayAct
from orbident.simulation.simulate import simulate

NOISE = {"gyro": 1e-4, "attitude": 1e-3, "position": 1e-3, "velocity": 1e-3}
"""Std of a sample, SI."""


NOTHING_ACTS = np.zeros((0, 15, 0))
"""The core's table of what acts from outside."""

SPIN = 20.0
"""rad/s: the base then turns at half a radian a second."""


class Small(NamedTuple):
    """A recording's problem, where the search starts, and the truth."""

    problem: Problem
    prior: Prior
    state: Unknowns
    beta: np.ndarray


def small_robot() -> Robot:
    """One arm link on a base with one wheel."""
    wheel = Wheel("rw", np.array([0.0, 0.0, 1.0]), 0.05, "held")
    return random_planar_robot(2, (0,), wheels=(wheel,))


def small_robot_in_space() -> Robot:
    """One arm link on a base with three wheels."""
    return random_robot(1, (0,), wheels=random_wheels(1, ["held", "held", "held"]))


def small_recording_in_space(robot: Robot) -> Recording:
    """A recording from rest: the base tumbles because the wheels spun up."""
    return simulate(robot, random_motion(robot, 1, 10.0, 50.0, "spun up"))


def small_recording(robot: Robot, duration: float = 20.0) -> Recording:
    """A recording from rest: the base turns because the wheel spun up."""
    motion = random_motion(robot, 1, duration, SPIN, "spun up")
    return simulate(robot, motion)


def small_flight(robot: Robot) -> Recording:
    """On a table or in space."""
    planar = robot.motion == "planar"
    return (small_recording if planar else small_recording_in_space)(robot)


def noisy(recording: Recording, seed: int) -> Recording:
    """The recording with white noise on the base's sensors, about z and in x and y."""
    random = np.random.default_rng(seed)
    columns = dict(recording.columns)
    for name in ("gyro.z", "position.x", "position.y", "velocity.x", "velocity.y"):
        std = NOISE[name.split(".")[0]]
        columns[name] = columns[name] + std * random.standard_normal(recording.t.size)
    angle = 2 * np.arctan2(columns["attitude.z"], columns["attitude.w"])
    angle += NOISE["attitude"] * random.standard_normal(angle.size)
    columns["attitude.z"], columns["attitude.w"] = np.sin(angle / 2), np.cos(angle / 2)
    return Recording(recording.t, columns)


def noisy_in_space(recording: Recording, seed: int) -> Recording:
    """The recording with white noise on all axes of the base's sensors."""
    random = np.random.default_rng(seed)
    columns = dict(recording.columns)
    for sensor in ("gyro", "position", "velocity"):
        for k in "xyz":
            noise = NOISE[sensor] * random.standard_normal(recording.t.size)
            columns[f"{sensor}.{k}"] = columns[f"{sensor}.{k}"] + noise
    x_WB = Rotation.from_quat(recording.vector("attitude", "xyzw"))
    turns = NOISE["attitude"] * random.standard_normal((recording.t.size, 3))
    turned = (x_WB * Rotation.from_rotvec(turns)).as_quat()
    columns |= {f"attitude.{k}": x for k, x in zip("xyzw", turned.T, strict=True)}
    return Recording(recording.t, columns)


def at_rest(
    robot: Robot, t: np.ndarray, allowed: Mapping[str, MayAct] | None = None
) -> RobotMotion:
    """A robot that does nothing, with what may act on it."""
    q, w = np.zeros((t.size, len(robot.joints))), np.zeros((t.size, 3))
    R_WB = np.tile(np.eye(3), (t.size, 1, 1))
    return RobotMotion(robot, t, q, q, R_WB, w, None, allowed=allowed or {})


def small_problem(robot: Robot, recording: Recording, off: float = 0.0) -> Small:
    """A problem in which nothing acts, with momentum known to be zero; `beta` starts so
    far off, relative."""
    robot = replace(robot, disturbances={})
    sets = minimal_sets(robot)
    sensors = sensors_of(robot, recording, dict.fromkeys(SENSORS, 0.0))
    samples = samples_of(robot, recording)
    problem = problem_of(robot, sets, samples, sensors)
    beta = sets.beta(robot.theta)
    signs = np.where(np.arange(beta.size) % 2, 1.0, -1.0)
    start = (1 + off * signs) * beta
    state = start_of(problem, samples, NOTHING, start)
    prior = prior_of(robot, sets, problem.declared, NOTHING, np.zeros(3))
    return Small(problem, prior, state, beta)
