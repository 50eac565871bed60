"""The minimal sets of large robots: whole, exact, and found without large matrices."""

import tracemalloc

import numpy as np
import pytest
from random_robots import DUAL_ARM, random_planar_robot, random_robot

from orbident.errors import InputError
from orbident.model.kinematics import momentum_regressors
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot

TOLERANCE = 1e-10
"""Part of the sum of the terms' sizes. Coefficients of the sets reach 1e4 where axes
are nearly parallel, and two eliminations follow each other: the worst observed is
2e-12."""


def check_momentum(robot: Robot) -> None:
    """`Y pi` is `h_rs = A theta - (S theta) x (P theta) / M`, for any parameters."""
    random = np.random.default_rng(1)
    q, qd = random.standard_normal((2, 20, len(robot.joints)))
    w = random.standard_normal((20, 3))
    if robot.motion == "planar":
        w[:, :2] = 0.0
    sets, at = minimal_sets(robot), momentum_regressors(robot, q, qd, w)
    theta = robot.theta.copy()
    free = list(robot.free_parameters)
    theta.flat[free] *= random.uniform(0.8, 1.2, len(free))
    S, P, A = (part @ theta.ravel() for part in at)
    h = (A - np.cross(S, P) / theta[:, 0].sum())[:, sets.regressors.momentum_axes]
    Y, _ = sets.regressors(q, qd, w)
    pi = sets.pi(theta)
    assert np.abs(Y @ pi - h).max() < TOLERANCE * (np.abs(Y) @ np.abs(pi)).max()


ROBOTS = {
    "three joints": load_robot("paper-spatial"),
    "in the plane": load_robot("cepheus-like"),
    "two arms": load_robot("dual-arm"),
    "nearly parallel axes": random_robot(5, DUAL_ARM),
    "sliding joints": random_robot(4, (0, 1, 0, 3, 1), (0, 2, 4)),
    "sliding in the plane": random_planar_robot(3, (0, 1, 0), (1,)),
    "no joints": random_robot(0, ()),
    "a long chain": random_robot(2, range(24)),
}


@pytest.mark.parametrize("robot", ROBOTS.values(), ids=ROBOTS)
def test_the_momentum_is_that_of_pi(robot: Robot):
    check_momentum(robot)


@pytest.mark.parametrize("joints", [2, 8, 24, 48])
def test_the_count_of_a_chain(joints: int):
    """Two first moments a link and three of the base; each link's products with those
    of all bodies before it, less two that its inertia holds; five inertias, six."""
    robot = random_robot(2, range(joints))
    sets = minimal_sets(robot)
    sigmas, iotas = 3 + 2 * joints, 6 + 5 * joints
    assert (sets.base.sigmas, sets.iotas) == (sigmas, iotas)
    products = sum(2 * (3 + 2 * k) for k in range(joints))
    assert len(sets.pi_of_beta) == iotas + products - 2 * joints
    check_momentum(robot)


def test_rows_of_pi_are_independent():
    """In random motion `Y` has full rank."""
    robot = random_robot(3, range(8))
    random = np.random.default_rng(0)
    sets = minimal_sets(robot)
    q, qd = random.standard_normal((2, 300, 8))
    Y, _ = sets.regressors(q, qd, random.standard_normal((300, 3)))
    s = np.linalg.svd(Y.reshape(-1, Y.shape[2]), compute_uv=False)
    assert s[-1] > 1e-6 * s[0]


def test_too_many_joints_are_refused():
    with pytest.raises(InputError, match=r"has 70 joints, and so 10296 products .* 60"):
        minimal_sets(random_robot(1, range(70)))


def test_far_too_many_joints_are_refused_before_any_large_table():
    robot = random_robot(1, range(2000))
    tracemalloc.start()
    with pytest.raises(InputError, match=r"has 2000 joints; .* 60"):
        minimal_sets(robot)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 1e6
