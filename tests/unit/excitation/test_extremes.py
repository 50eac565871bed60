from dataclasses import replace

import numpy as np
import pytest
from random_motions import random_motion
from random_robots import random_planar_robot, random_robot, random_wheels

from orbident.excitation.guarantee import NODES, base_extremes_of, extremes_of, floated
from orbident.robot.description import GearedRotor
from orbident.simulation.free_floating import BaseState, free_floating
from orbident.trajectories.trajectory import Trajectory


def random_trajectory(seed: int, harmonics: int = 5) -> Trajectory:
    random = np.random.default_rng(seed)
    joints = ("one", "two", "three")
    a, b = random.standard_normal((2, 3, harmonics))
    start, end = 0.3 * random.standard_normal((2, 3, 3))
    return Trajectory(30.0, joints, a, b, start, end)


@pytest.mark.parametrize("seed", range(5))
def test_extremes_hold_between_nodes_and_are_tight(seed):
    trajectory = random_trajectory(seed)
    found = extremes_of(trajectory)
    t = np.linspace(0.0, 30.0, 100 * NODES + 1)
    q, qd, qdd = trajectory.at(t)
    assert (found.position[:, 0] <= q.min(axis=0)).all()
    assert (found.position[:, 1] >= q.max(axis=0)).all()
    assert (found.velocity >= np.abs(qd).max(axis=0)).all()
    assert (found.acceleration >= np.abs(qdd).max(axis=0)).all()
    # h^2/8 of derivatives of the order of w^2 = 1: 7e-6, of extremes above one.
    np.testing.assert_allclose(found.velocity, np.abs(qd).max(axis=0), rtol=1e-4)
    np.testing.assert_allclose(found.acceleration, np.abs(qdd).max(axis=0), rtol=1e-4)


def finely(robot, trajectory, times):
    initial = trajectory.initial
    speeds = initial.wheel_speeds(robot.wheel_names)
    start = BaseState(
        initial.angular_velocity, initial.attitude, initial.velocity, speeds
    )
    t = np.linspace(0.0, trajectory.duration, times * (NODES - 1) + 1)
    return free_floating(robot, trajectory.motion, t, start, 1e-6)


CASES = {
    "revolute": random_robot(0, (0, 1, 0), wheels=random_wheels(0, ("held",)), base=5),
    "prismatic": random_robot(1, (0, 1), (1,), random_wheels(1, ("free",)), base=5),
    "planar": random_planar_robot(2, (0, 1)),
    # Rotors with more momentum than the links.
    "geared": replace(
        random_robot(3, (0, 1), wheels=random_wheels(0, ("held",)), base=20),
        rotors={"joint1": GearedRotor(160, 0.05), "joint2": GearedRotor(-100, 0.1)},
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_bounds_hold_on_a_finer_grid(name):
    robot = CASES[name]
    trajectory = random_motion(robot, duration=10.0)
    found = base_extremes_of(robot, floated(robot, trajectory), extremes_of(trajectory))
    fine = finely(robot, trajectory, 10)
    rate = np.linalg.norm(fine.w, axis=1).max()
    half = np.clip(np.abs(fine.attitude @ fine.attitude[0]), 0.0, 1.0)
    assert rate <= found.rate
    assert 2 * np.arccos(half).max() <= found.excursion
    assert np.abs(fine.qd_rw).max(initial=0.0) <= found.wheel_speed


@pytest.mark.parametrize("name", CASES)
def test_the_change_of_rate_is_bounded(name):
    """The bound between samples is that of `|w'|`, which differences show."""
    robot = CASES[name]
    trajectory = random_motion(robot, duration=10.0)
    motion = floated(robot, trajectory)
    found = base_extremes_of(robot, motion, extremes_of(trajectory))
    sampled = np.linalg.norm(motion.w, axis=1).max()
    step = motion.t[1]
    fastest = np.linalg.norm(np.diff(motion.w, axis=0), axis=1).max() / step
    allowed = (found.rate - sampled) / (step / 2)
    assert fastest <= allowed


def test_tight_enough_to_be_of_use(servicer, table_2):
    found = base_extremes_of(servicer, floated(servicer, table_2), extremes_of(table_2))
    motion = floated(servicer, table_2)
    sampled = np.linalg.norm(motion.w, axis=1).max()
    # Half a step of 0.01 s, if all joints did their worst at once, arm straight.
    assert found.rate < 1.2 * sampled
