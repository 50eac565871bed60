"""The terms of momentum and velocity and their derivatives, on any tree, against sums
over bodies as a textbook has them."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from obvious_momentum import system_motion
from random_robots import random_parents, random_planar_robot, random_robot

from orbident import _core
from orbident.model.core_robot import core_tree
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import Robot

pytestmark = pytest.mark.core

SYMMETRIC = ([0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2])
STEP = 1e-4
"""Step of central differences with an error of its fourth power."""


def obvious(robot: Robot, theta: np.ndarray, q: np.ndarray, qd: np.ndarray):
    """`D`, `D_q qd`, `r_cm` and `J_cm qd`, one below the other."""
    robot = replace(robot, theta=theta.reshape(-1, 10))
    still = np.zeros_like(qd)
    D = [system_motion(robot, q, still, e).h_rs for e in np.eye(3)]
    moving = system_motion(robot, q, qd, np.zeros(3))
    M = robot.mass
    parts = np.array(D)[SYMMETRIC], moving.h_rs, moving.first_moment / M
    return np.concatenate([*parts, moving.linear / M])


def derivative(f, x: np.ndarray) -> np.ndarray:
    """Columns: by each entry of `x`."""
    columns = []
    for e in np.eye(x.size):
        one, two = (f(x + k * STEP * e) - f(x - k * STEP * e) for k in (1, 2))
        columns.append((8 * one - two) / (12 * STEP))
    return np.array(columns).T


@settings(max_examples=10, deadline=None)
@given(
    seed=st.integers(0, 2**20),
    joints=st.integers(1, 5),
    planar=st.booleans(),
    slides=st.integers(0, 31),
    massless=st.integers(0, 31),
)
def test_terms_and_their_derivatives(seed, joints, planar, slides, massless):
    random = np.random.default_rng(seed)
    sliding = tuple(k for k in range(joints) if slides >> k & 1)
    make = random_planar_robot if planar else random_robot
    robot = make(seed, random_parents(random, joints), sliding)
    theta = robot.theta.copy()
    theta[[k + 1 for k in range(joints) if massless >> k & 1]] = 0.0
    robot = replace(robot, theta=theta)
    sets = minimal_sets(robot)
    theta_of, beta = sets.base.theta_of, sets.beta(robot.theta)
    q, qd, qdd = random.standard_normal((3, joints))

    found = _core.momentum_terms(core_tree(robot), theta_of, beta, q, qd, qdd)
    by_q = derivative(lambda x: obvious(robot, theta_of @ beta, x, qd), q)
    by_qd = derivative(lambda x: obvious(robot, theta_of @ beta, q, x), qd)
    by_beta = derivative(lambda x: obvious(robot, theta_of @ x, q, qd), beta)
    terms = obvious(robot, theta_of @ beta, q, qd)
    rates = by_q @ qd + by_qd @ qdd
    expected = np.column_stack([terms, rates, by_q, by_qd, by_beta])
    # Rounding of numbers of the order of 10 over the step.
    np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-8)
