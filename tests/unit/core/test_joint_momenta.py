"""The joints' momenta and slopes of the energy, against Eq. 6 and differences."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_robots import random_parents, random_robot

from orbident import _core
from orbident.model.core_robot import core_tree
from orbident.model.kinematics import carried_inertia, inertia_at
from orbident.robot.description import Robot

pytestmark = pytest.mark.core

STEP = 1e-3
"""Step of central differences with an error of its fourth power."""


def momenta(robot: Robot, q: np.ndarray, qd: np.ndarray, w: np.ndarray) -> np.ndarray:
    """`D_q^T w + D_qq qd`."""
    at = inertia_at(robot, q)
    return at.D_q.T @ w + at.D_qq @ qd


def energy(robot: Robot, q: np.ndarray, qd: np.ndarray, w: np.ndarray) -> float:
    """Kinetic, about the system CM, wheels apart (Eq. 6)."""
    at = inertia_at(robot, q)
    return float(w @ at.D @ w / 2 + w @ at.D_q @ qd + qd @ at.D_qq @ qd / 2)


def derivative(f, x: np.ndarray) -> np.ndarray:
    """The last axis is by each entry of `x`."""
    columns = []
    for e in np.eye(x.size):
        one, two = (f(x + k * STEP * e) - f(x - k * STEP * e) for k in (1, 2))
        columns.append((8 * one - two) / (12 * STEP))
    return np.stack(columns, axis=-1)


@settings(max_examples=8, deadline=None)
@given(seed=st.integers(0, 2**20), joints=st.integers(1, 5), slides=st.integers(0, 31))
def test_momenta_and_slopes_of_the_energy(seed: int, joints: int, slides: int):
    random = np.random.default_rng(seed)
    sliding = tuple(k for k in range(joints) if slides >> k & 1)
    robot = random_robot(seed, random_parents(random, joints), sliding)
    q, qd = random.standard_normal((2, joints))
    w = random.standard_normal(3)

    def found(q: np.ndarray, qd: np.ndarray, w: np.ndarray, theta: np.ndarray):
        at = (theta[None], q[None], qd[None], w[None])
        return _core.joint_momenta(core_tree(robot), np.eye(theta.size), *at)[0]

    theta = robot.theta.ravel()
    table = found(q, qd, w, theta)
    slopes = derivative(lambda x: np.array(energy(robot, x, qd, w)), q)
    h = inertia_at(robot, q).D @ w + inertia_at(robot, q).D_q @ qd
    expected = np.concatenate([h, momenta(robot, q, qd, w), slopes])
    np.testing.assert_allclose(table[:, 0], expected, rtol=1e-8, atol=1e-8)

    of_all = [
        derivative(lambda x: found(q, qd, x, theta)[:, 0], w),
        derivative(lambda x: found(q, x, w, theta)[:, 0], qd),
        derivative(lambda x: found(x, qd, w, theta)[:, 0], q),
        derivative(lambda x: found(q, qd, w, x)[:, 0], theta),
    ]
    np.testing.assert_allclose(table[:, 1:], np.hstack(of_all), rtol=1e-7, atol=1e-7)


@pytest.mark.parametrize("slides", [(), (1,)])
def test_carried_inertia_is_that_of_a_joint_on_a_base_that_is_held(slides):
    """A base a million times as heavy as the arm does not move."""
    robot = random_robot(3, (0, 1, 2), slides)
    theta = robot.theta.copy()
    theta[0] *= 1e9
    held = inertia_at(
        Robot(**{**vars(robot), "theta": theta}), np.zeros(len(robot.joints))
    )
    for k in range(len(robot.joints)):
        carried = carried_inertia(robot, k) @ robot.theta.ravel()
        assert carried == pytest.approx(held.D_qq[k, k], rel=1e-6)
