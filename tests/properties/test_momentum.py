"""The vectorised kinematics and momentum against the textbook's, on any tree."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from obvious_momentum import body_motion, system_motion
from one_state import only_state
from random_robots import random_robot

from orbident.model.kinematics import inertia_at, momentum_regressors, poses
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import Robot

pytestmark = pytest.mark.core

JOINTS = 5
# Entries of the order of 1 to 100, sums of some tens of products; the worst observed,
# relative to the largest entry, is 2e-15.
TOLERANCE = 1e-13


class Recipe(NamedTuple):
    """Any tree of this size, any of its joints sliding, any of its links massless.

    The robot is made from it in the test: strategies must not use random numbers,
    which the run-time checks of its functions do.
    """

    seed: int
    parents: tuple[int, ...]
    prismatic: set[int]
    massless: set[int]

    def robot(self) -> Robot:
        robot = random_robot(self.seed, self.parents, sorted(self.prismatic))
        theta = robot.theta.copy()
        theta[[k + 1 for k in self.massless]] = 0.0
        return replace(robot, theta=theta)


some_joints = st.sets(st.integers(0, JOINTS - 1))
recipes = st.builds(
    Recipe,
    seed=st.integers(0, 999),
    parents=st.tuples(*(st.integers(0, k) for k in range(JOINTS))),
    prismatic=some_joints,
    massless=some_joints,
)


def random_state(robot: Robot):
    random = np.random.default_rng(len(robot.name))
    q, qd = random.standard_normal((2, len(robot.joints)))
    return q, qd, random.standard_normal(3)


def everything(robot: Robot, q: np.ndarray, qd: np.ndarray, w: np.ndarray):
    """Poses, momentum regressors and inertia of one state."""
    at = only_state(poses(robot, q[None]))
    regressors = only_state(momentum_regressors(robot, q[None], qd[None], w[None]))
    return at, regressors, inertia_at(robot, q)


def check_against_the_textbook(robot: Robot):
    q, qd, w = random_state(robot)
    at, regressors, system = everything(robot, q, qd, w)
    bodies = [body_motion(robot, i, q, qd, w) for i in range(len(robot.bodies))]
    R, d, _, v_i = (np.array(column) for column in zip(*bodies, strict=True))
    assert_close(at.R, R)
    assert_close(at.d, d)
    assert_close(regressors.P[:, ::10].T, v_i)

    total, theta = system_motion(robot, q, qd, w), robot.theta.ravel()
    assert_close(regressors.S @ theta, total.first_moment)
    assert_close(regressors.P @ theta, total.linear)
    assert_close(regressors.A @ theta, total.angular)
    assert_close(system.D @ w + system.D_q @ qd, total.h_rs)
    r_cm = total.first_moment / robot.mass
    assert_close(system.r_cm, r_cm)
    assert_close(np.cross(w, system.r_cm) + system.J_cm @ qd, total.linear / robot.mass)


def assert_close(ours, textbook):
    scale = max(np.abs(textbook).max(), 1.0)
    np.testing.assert_allclose(ours, textbook, rtol=0, atol=TOLERANCE * scale)


@settings(max_examples=30)
@given(recipes)
def test_any_tree(recipe):
    check_against_the_textbook(recipe.robot())


def test_no_joints():
    check_against_the_textbook(random_robot(0, ()))


def test_only_sliding_joints():
    check_against_the_textbook(random_robot(0, range(JOINTS), range(JOINTS)))


def test_a_chain_of_massless_links_with_a_tip():
    robot = random_robot(0, range(JOINTS))
    theta = robot.theta.copy()
    theta[1:-1] = 0.0
    check_against_the_textbook(replace(robot, theta=theta))


@pytest.mark.parametrize("parameter", range(10))
def test_each_column_is_the_momentum_of_one_parameter(parameter):
    """The parameter is each body's in turn: nothing cancels between the columns."""
    robot = random_robot(0, (0, 1, 1, 0, 4), (2,))
    q, qd, w = random_state(robot)
    _, regressors, _ = everything(robot, q, qd, w)
    for body in range(len(robot.bodies)):
        theta = np.zeros_like(robot.theta)
        theta[body, parameter] = 1.0
        # h_rs divides by the mass, which none but the first parameter has.
        with np.errstate(invalid="ignore", divide="ignore"):
            alone = system_motion(replace(robot, theta=theta), q, qd, w)
        column = 10 * body + parameter
        assert_close(regressors.S[:, column], alone.first_moment)
        assert_close(regressors.P[:, column], alone.linear)
        assert_close(regressors.A[:, column], alone.angular)


@settings(max_examples=10)
@given(recipes)
def test_momentum_is_linear_in_the_rates(recipe):
    """`D` and `D_q` do not depend on them."""
    robot = recipe.robot()
    q, _, _ = random_state(robot)
    random = np.random.default_rng(recipe.seed)
    rates = random.standard_normal((2, JOINTS + 3))
    a, b = random.standard_normal(2)

    def A_theta(rate):
        qd, w = rate[:JOINTS], rate[JOINTS:]
        _, regressors, _ = everything(robot, q, qd, w)
        return regressors.A @ robot.theta.ravel()

    both = A_theta(a * rates[0] + b * rates[1])
    assert_close(both, a * A_theta(rates[0]) + b * A_theta(rates[1]))


@settings(max_examples=10)
@given(recipes)
def test_rate_of_the_momentum_along_the_joints(recipe):
    """`d/dt (Y pi)` with the base rate held, by central differences."""
    robot = recipe.robot()
    regressors = minimal_sets(robot).regressors
    random = np.random.default_rng(recipe.seed)
    q, qd, qdd = random.standard_normal((3, 1, JOINTS))
    w = random.standard_normal((1, 3))
    pi = random.standard_normal(regressors(q, qd, w)[0].shape[2])
    # Errors of the difference: h^2 of the third derivative, and rounding over h.
    h = 1e-5
    ahead, behind = (
        regressors(q + s * h * qd, qd + s * h * qdd, w)[0] @ pi for s in (1, -1)
    )
    found = regressors.momentum_rate((q, qd, qdd), w, pi)
    np.testing.assert_allclose(found, (ahead - behind) / (2 * h), rtol=0, atol=1e-6)
