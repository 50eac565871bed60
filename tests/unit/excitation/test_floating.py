"""The search's own free floating, against `dynamics.free_floating`."""

from typing import NamedTuple

import numpy as np
import pytest
from random_motions import random_motion
from random_robots import random_robot, random_wheels

from orbident.excitation.floating import NodalMotion, craft_of, was_at_rest
from orbident.model.kinematics import inertia
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.simulation.free_floating import BaseState, FreeFloating, free_floating
from orbident.trajectories.trajectory import Trajectory

STEPS = 400


class Both(NamedTuple):
    ours: NodalMotion
    theirs: FreeFloating


def both(robot: Robot, trajectory: Trajectory, steps: int = STEPS) -> Both:
    initial = trajectory.initial
    t = np.linspace(0.0, trajectory.duration, 2 * steps + 1)
    start = BaseState(
        initial.angular_velocity,
        initial.attitude,
        initial.velocity,
        initial.wheel_speeds(robot.wheel_names),
    )
    at_rest = was_at_rest(robot, initial, trajectory.start)
    craft = craft_of(robot, minimal_sets(robot), initial, trajectory.start, at_rest)
    q, qd, _ = trajectory.at(t)
    ours = craft.along(q, qd, float(t[2]))
    return Both(ours, free_floating(robot, trajectory, t[::2], start))


def error(pair: Both) -> float:
    return float(np.abs(pair.ours.w - pair.theirs.w).max())


def random_case(modes):
    robot = random_robot(0, (0, 1), wheels=random_wheels(0, modes), base=5.0)
    return robot, random_motion(robot, duration=10.0)


def test_along_table_2(servicer, table_2):
    pair = both(servicer, table_2)
    # (0.2 s of 0.1 rad/s)^4 / 120 = 1e-9 a step, over eight radians in all.
    assert error(pair) < 1e-6 * np.abs(pair.theirs.w).max()


@pytest.mark.parametrize("modes", [("held", "held"), ("free", "held"), ("free",) * 2])
def test_of_fourth_order_on_random_robots(modes):
    robot, trajectory = random_case(modes)
    coarse, fine = (error(both(robot, trajectory, n)) for n in (400, 800))
    # Twice the nodes, a sixteenth of the error.
    assert 12.0 < coarse / fine < 20.0


def test_wheels_that_are_free():
    robot, trajectory = random_case(("free", "held"))
    pair = both(robot, trajectory, 1600)
    # A wheel changes by the base rate, whose error is of fourth order: 1e-6 rad/s.
    np.testing.assert_allclose(pair.ours.qd_rw, pair.theirs.qd_rw, rtol=0, atol=1e-5)


def test_in_the_plane():
    robot = load_robot("cepheus-like")
    pair = both(robot, random_motion(robot, duration=10.0, start="spun up"))
    assert error(pair) < 1e-12
    # RK4 over 25 ms at 2 rad/s: 1e-9 rad a radian; the sign of a quaternion is free.
    same = np.abs(np.einsum("ni,ni->n", pair.ours.x_WB, pair.theirs.attitude))
    np.testing.assert_allclose(same, 1.0, rtol=0, atol=1e-9)


def test_regressors_and_inertia_are_those_of_the_motion(servicer, table_2):
    pair = both(servicer, table_2)
    Y, W = minimal_sets(servicer).regressors(pair.theirs.q, pair.theirs.qd, pair.ours.w)
    at = inertia(servicer, pair.theirs.q)
    # Entries of order one, but for rounding.
    np.testing.assert_allclose(pair.ours.Y, Y, rtol=0, atol=1e-12)
    np.testing.assert_allclose(pair.ours.W, W, rtol=0, atol=1e-12)
    np.testing.assert_allclose(pair.ours.E, np.linalg.inv(at.D), rtol=1e-12)
    np.testing.assert_allclose(pair.ours.r_cm, at.r_cm, rtol=0, atol=1e-14)
