"""The minimal sets are minimal: as many parameters as the model has ranks.

The model is evaluated with nothing of what finds the sets: momentum is nonlinear in
`theta`, and what it shows of `theta` is the rank of its Jacobian and of its values.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from random_robots import DUAL_ARM, random_planar_robot, random_robot

from orbident.model.kinematics import momentum_regressors
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import Robot
from orbident.robot.parameters import PER_BODY
from orbident.robot.robot_file import load_robot

# Singular values relative to the largest, columns scaled to 1: the smallest that
# counts is 2e-5 (the paper's arm), the largest that does not 2e-16.
NOTHING = 1e-10


class Counts(NamedTuple):
    pi: int
    phi: int
    base: int


PAPER = load_robot("paper-spatial")
ROBOTS: dict[str, tuple[Robot, Counts]] = {
    "paper-spatial": (PAPER, Counts(19, 5, 18)),
    "paper-spatial-unstructured": (replace(PAPER, structure={}), Counts(45, 9, 31)),
    "cepheus-like": (load_robot("cepheus-like"), Counts(8, 4, 8)),
    "one-joint": (random_robot(0, (0,)), Counts(15, 5, 17)),
    "one-slide": (random_robot(0, (0,), (0,)), Counts(10, 4, 14)),
    "three-slides": (random_robot(0, (0, 1, 2), (0, 1, 2)), Counts(21, 6, 22)),
    "two-arms-three-joints": (random_robot(0, (0, 1, 0)), Counts(45, 9, 31)),
    "dual-arm": (random_robot(0, DUAL_ARM), Counts(120, 15, 52)),
    "dual-arm-with-slides": (random_robot(0, DUAL_ARM, (1, 4)), Counts(91, 13, 46)),
    # One pass of Gram-Schmidt finds 109 here, or fails, as the processor may be.
    "dual-arm-one-slide": (random_robot(3, DUAL_ARM, (1,)), Counts(105, 14, 49)),
    "planar-tree": (random_planar_robot(0, (0, 1, 0)), Counts(16, 8, 13)),
    "planar-with-slide": (random_planar_robot(0, (0, 1, 0), (1,)), Counts(16, 7, 13)),
}


class Model(NamedTuple):
    """The momentum regressors over random motion, for the axes that are conserved."""

    S: np.ndarray
    P: np.ndarray
    A: np.ndarray
    free: np.ndarray
    """1 where the robot's structure leaves the parameter free."""
    planar: bool

    def momentum(self, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """`h_rs` and `P theta / M`."""
        S, P, A = self.S @ theta, self.P @ theta, self.A @ theta
        M = theta[::PER_BODY].sum()
        return self.seen(A - np.cross(S, P) / M, P / M)

    def jacobian(self, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The derivatives of `h_rs` and `P theta / M` by `theta`."""
        S, P = (self.S @ theta)[..., None], (self.P @ theta)[..., None]
        M, mass = theta[::PER_BODY].sum(), np.zeros(theta.size)
        mass[::PER_BODY] = 1.0
        products = cross(self.S, P) + cross(S, self.P)
        h_rs = self.A - products / M + cross(S, P) * mass / M**2
        return self.seen(h_rs, self.P / M - P * mass / M**2)

    def seen(self, h: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        turning, moving = ([2], [0, 1]) if self.planar else ([0, 1, 2], [0, 1, 2])
        h, v = h[:, turning], v[:, moving]
        return h.reshape(-1, *h.shape[2:]), v.reshape(-1, *v.shape[2:])


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.cross(a, b, axis=1)


def model_of(robot: Robot, samples: int = 160) -> Model:
    random = np.random.default_rng(3)
    q, qd = random.standard_normal((2, samples, len(robot.joints)))
    w = random.standard_normal((samples, 3))
    planar = robot.motion == "planar"
    if planar:
        w[:, :2] = 0.0
    at = momentum_regressors(robot, q, qd, w)
    free = np.zeros(robot.theta.size)
    free[list(robot.free_parameters)] = 1.0
    S, P, A = (X * free for X in at)
    return Model(S, P, A, free, planar)


def rank(X: np.ndarray) -> int:
    scale = np.linalg.norm(X, axis=0)
    X = X / np.where(scale > NOTHING * scale.max(), scale, np.inf)
    values = np.linalg.svd(X, compute_uv=False)
    return int(np.sum(values > NOTHING * values[0]))


@pytest.mark.parametrize("name", ROBOTS)
def test_counts(name):
    robot, counts = ROBOTS[name]
    sets = minimal_sets(robot)
    found = Counts(
        len(sets.pi(robot.theta)),
        len(sets.phi(robot.theta)),
        len(sets.beta(robot.theta)),
    )
    assert found == counts


@pytest.mark.parametrize("name", ROBOTS)
def test_base_parameters_are_as_many_as_the_rank_of_the_nonlinear_model(name):
    """The rank is that of the Jacobian of `[h_rs; P theta / M]` by `theta`."""
    robot, counts = ROBOTS[name]
    model = model_of(robot)
    assert rank(np.concatenate(model.jacobian(robot.theta.ravel()))) == counts.base


@pytest.mark.parametrize("name", ROBOTS)
def test_pi_and_phi_are_as_many_as_the_ranks_over_random_inertias(name):
    """A linear model `Y pi` of all robots of this shape needs at least that many."""
    robot, counts = ROBOTS[name]
    model, random = model_of(robot), np.random.default_rng(4)
    values = []
    for _ in range(counts.pi + 10):
        theta = random.standard_normal(robot.theta.size)
        theta[::PER_BODY] = random.uniform(0.5, 1.5, len(robot.bodies))
        values.append(model.momentum(theta * model.free))
    h_rs, v = zip(*values, strict=True)
    assert rank(np.array(h_rs).T) == counts.pi
    assert rank(np.array(v).T) == counts.phi


def test_mass_of_a_body_without_joints_does_not_show():
    """Its momentum holds the inertia about the CM and the CM itself: 6 + 3.

    `M` stays among the base parameters all the same.
    """
    robot = random_robot(0, ())
    assert rank(np.concatenate(model_of(robot).jacobian(robot.theta.ravel()))) == 9
    assert len(minimal_sets(robot).beta(robot.theta)) == 10


def test_bundled_dual_arm_counts():
    """`phi`: three for the base, two for each of the fourteen joints."""
    sets = minimal_sets(load_robot("dual-arm"))
    assert sets.pi_of_beta.shape == (496, 108)
    assert sets.base.sigmas == 31
