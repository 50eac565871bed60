"""The search's own free floating, against `dynamics.free_floating`."""

from typing import NamedTuple

import jax
import numpy as np
import pytest
from random_motions import random_motion
from random_robots import random_robot, random_wheels

from orbident.dynamics.free_floating import BaseState, FreeFloating, free_floating
from orbident.excitation.floating import (
    Floating,
    float_along,
    shown_along,
    spacecraft_of,
)
from orbident.excitation.start import was_at_rest
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot
from orbident.trajectories.trajectory import Trajectory

NODES = 401


class Both(NamedTuple):
    ours: Floating
    theirs: FreeFloating


def both(robot: Robot, trajectory: Trajectory, nodes: int = NODES) -> Both:
    initial = trajectory.initial
    t = np.linspace(0.0, trajectory.duration, nodes)
    speeds = initial.wheel_speeds(robot.wheel_names)
    start = BaseState(
        initial.angular_velocity, initial.attitude, initial.velocity, speeds
    )
    sets = minimal_sets(robot)
    rest = was_at_rest(robot, initial, trajectory.start)
    craft = spacecraft_of(robot, sets.regressors, initial, rest)
    q, qd, _ = trajectory.at(t)
    shown = jax.jit(shown_along)(sets.regressors, q, qd)
    pi, phi = sets.pi(robot.theta), sets.phi(robot.theta)
    ours = jax.jit(float_along)(craft, shown, pi, phi, t[1])
    return Both(ours, free_floating(robot, trajectory, t, start))


def error(pair: Both) -> float:
    axes = slice(2, 3) if pair.ours.w.shape[1] == 1 else slice(None)
    return float(np.abs(np.asarray(pair.ours.w) - pair.theirs.w[:, axes]).max())


def random_case(modes):
    robot = random_robot(0, (0, 1), wheels=random_wheels(0, modes), base=5.0)
    return robot, random_motion(robot, duration=10.0)


def test_along_table_2_within_the_order_of_the_step(servicer, table_2):
    pair = both(servicer, table_2)
    rates = np.abs(pair.theirs.w).max()
    # (0.2 s of 0.1 rad/s)^2 = 4e-4, over eight radians in all.
    assert error(pair) < 2e-3 * rates


@pytest.mark.parametrize("modes", [("held", "held"), ("free", "held"), ("free",) * 2])
def test_of_second_order_on_random_robots(modes):
    robot, trajectory = random_case(modes)
    coarse, fine = (error(both(robot, trajectory, n)) for n in (401, 801))
    # Twice the nodes, a quarter of the error.
    assert 3.0 < coarse / fine < 5.0


def test_wheels_that_are_free(servicer):
    robot, trajectory = random_case(("free", "held"))
    pair = both(robot, trajectory, 1601)
    # A wheel of speed 200 changes with the base rate, whose error is second order.
    np.testing.assert_allclose(pair.ours.qd_rw, pair.theirs.qd_rw, rtol=0, atol=1e-3)


def test_in_the_plane_the_rate_is_exact():
    robot = load_robot("cepheus-like")
    pair = both(robot, random_motion(robot, duration=10.0, start="spun up"))
    assert error(pair) < 1e-12
    turned = 2 * np.arccos(
        np.clip(np.abs(pair.theirs.attitude @ pair.theirs.attitude[0]), 0, 1)
    )
    ours = 2 * np.arccos(np.clip(np.asarray(pair.ours.half_turn), 0, 1))
    # The trapezoidal rule: h^2 / 12 of the rate's curvature, 1e-4 at most.
    np.testing.assert_allclose(ours, turned, rtol=0, atol=1e-3)


def test_regressors_and_inertia_are_those_of_the_motion(servicer, table_2):
    pair = both(servicer, table_2)
    sets = minimal_sets(servicer)
    k = 137
    w = np.asarray(pair.ours.w[k])
    Y, W = jax.jit(lambda *state: sets.regressors(*state))(
        pair.theirs.q[k], pair.theirs.qd[k], w
    )
    # Entries of order one, and linear in the rates but for rounding.
    np.testing.assert_allclose(pair.ours.Y[k], Y, rtol=0, atol=1e-12)
    np.testing.assert_allclose(pair.ours.W[k], W, rtol=0, atol=1e-12)
