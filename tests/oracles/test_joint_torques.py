"""`Dynamics.torques` is the inverse dynamics of Pinocchio and of MuJoCo.

Theirs start from accelerations of the base as well: these are solved for, so that no
force acts on it.
"""

# Pinocchio and MuJoCo are compiled and have no stubs for what they export.
# pyright: reportAttributeAccessIssue=false

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from mujoco_model import mujoco_model
from pinocchio_model import pinocchio_model
from random_robots import random_parents, random_robot, random_wheels
from wheels_as_joints import wheels_as_joints

from orbident.model.minimal_sets import minimal_sets
from orbident.model.reconstruction import Dynamics, reconstructed
from orbident.robot.description import Robot

RTOL = 1e-9
"""A part of the largest torque: bodies from base parameters have fewer right digits
than bodies that are given."""

SHAPES = [(0, 1, 2, 3), (0, 1, 0, 3), None]
"""Parents of a serial arm and of two arms; any tree."""

STATES = 5


def some_robot(seed: int, shape, wheels: int) -> Robot:
    random = np.random.default_rng(seed)
    parents = shape or random_parents(random, 6)
    slides = np.flatnonzero(random.random(len(parents)) < 0.4).tolist()
    spin = random_wheels(seed, ("held",) * wheels)
    # A heavy base, from which wheels can be taken.
    return random_robot(seed, parents, slides, spin, base=20.0)


def by_pinocchio(robot: Robot, q, w, qd, qdd) -> np.ndarray:
    """RNEA, with those accelerations of the base for which no force acts on it."""
    made = pinocchio_model(robot)
    data, at, v = made.model.createData(), made.q(q), made.v(w, qd)
    base, own = made.rows[:6], made.rows[6:]

    def forces(of_base) -> np.ndarray:
        a = np.zeros(made.model.nv)
        a[base], a[own] = of_base, qdd
        return pin.rnea(made.model, data, at, v, a).copy()

    at_zero = forces(np.zeros(6))
    A = np.column_stack([(forces(e) - at_zero)[base] for e in np.eye(6)])
    return forces(np.linalg.solve(A, -at_zero[base]))[own]


def by_mujoco(robot: Robot, q, w, qd, qdd) -> np.ndarray:
    """`mj_inverse`, as above; the base is level, so that its axes are inertial."""
    model = mujoco_model(robot, ())
    data = mujoco.MjData(model)
    own = [model.joint(name).dofadr[0] for name in robot.joint_names]
    at, data.qvel[3:6] = [model.joint(n).qposadr[0] for n in robot.joint_names], w
    data.qpos[at], data.qvel[own] = q, qd

    def forces(of_base) -> np.ndarray:
        data.qacc[:6], data.qacc[own] = of_base, qdd
        mujoco.mj_inverse(model, data)
        return data.qfrc_inverse.copy()

    at_zero = forces(np.zeros(6))
    A = np.column_stack([(forces(e) - at_zero)[:6] for e in np.eye(6)])
    return forces(np.linalg.solve(A, -at_zero[:6]))[own]


def dynamics_of(robot: Robot) -> Dynamics:
    beta = minimal_sets(robot).beta(robot.theta)
    return reconstructed(robot, beta, np.zeros((beta.size, beta.size)))


@pytest.mark.parametrize("engine", [by_pinocchio, by_mujoco])
@pytest.mark.parametrize("wheels", [0, 2])
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("seed", range(3))
def test_torques_of_a_motion(seed, shape, wheels, engine):
    robot = some_robot(seed, shape, wheels)
    random, K = np.random.default_rng(seed), len(robot.joints)
    q, qd, qdd = random.standard_normal((3, STATES, K))
    w = random.standard_normal((STATES, 3))
    qd_rw = 200 * random.standard_normal((STATES, wheels))
    qdd_rw = 10 * random.standard_normal((STATES, wheels))
    found = dynamics_of(robot).torques(q, qd, qdd, w=w, qd_rw=qd_rw, qdd_rw=qdd_rw)
    whole, still = wheels_as_joints(robot), np.zeros((STATES, wheels))
    rows = zip(
        np.hstack([q, still]),
        w,
        np.hstack([qd, qd_rw]),
        np.hstack([qdd, qdd_rw]),
        strict=True,
    )
    expected = np.array([engine(whole, *row)[:K] for row in rows])
    scale = np.abs(expected).max()
    np.testing.assert_allclose(found, expected, rtol=0, atol=RTOL * scale)


@pytest.mark.parametrize("seed", range(3))
def test_without_momentum(seed):
    """The base's rate, if nobody gives it: no momentum about the CM by Pinocchio."""
    robot = some_robot(seed, None, 0)
    q, qd, qdd = np.random.default_rng(seed).standard_normal((3, len(robot.joints)))
    made = pinocchio_model(robot)
    data, at = made.model.createData(), made.q(q)

    def momentum(w, qd) -> np.ndarray:
        return pin.computeCentroidalMomentum(
            made.model, data, at, made.v(w, qd)
        ).angular

    still = np.zeros_like(qd)
    A = np.column_stack([momentum(e, still) for e in np.eye(3)])
    w = np.linalg.solve(A, -momentum(np.zeros(3), qd))
    expected = by_pinocchio(robot, q, w, qd, qdd)
    found = dynamics_of(robot).torques(q, qd, qdd)
    scale = np.abs(expected).max()
    np.testing.assert_allclose(found, expected, rtol=0, atol=RTOL * scale)
