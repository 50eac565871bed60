"""`H+`, `c+` and the Jacobians are Pinocchio's, mapped to the paper's speeds.

Pinocchio's speeds are `[v_S, w, qd, qd_rw]`, with the wheels as joints. With `T` so
that `v_pin = T v`:  H+ = T^T H T  and  c+ = T^T (H T' v + c).
"""

# Pinocchio is compiled and has no stubs.
# pyright: reportAttributeAccessIssue=false

from typing import NamedTuple

import numpy as np
import pinocchio as pin
import pytest
from pinocchio_model import PinocchioRobot, pinocchio_model
from random_robots import random_parents, random_robot, random_wheels
from wheels_as_joints import wheels_as_joints

from orbident import _core
from orbident.model.core_robot import core_robot
from orbident.model.equations_of_motion import (
    Equations,
    equations_of_motion,
    jacobian,
    velocity_of_S,
)
from orbident.robot.description import Robot
from orbident.robot.robot_file import load_robot

pytestmark = pytest.mark.core

STATES = 5

# Sums of some tens of products of float64 matrices on either side; of wheels at 200
# rad/s, Pinocchio's rotors lose a digit or two more. Relative to the largest entry of
# each quantity; the worst observed is 1e-13.
TOLERANCE = 1e-12


def some_robot(seed: int) -> Robot:
    """Any tree of seven joints, some of which slide, and three wheels."""
    random = np.random.default_rng(seed)
    slides = np.flatnonzero(random.random(7) < 0.3)
    wheels = random_wheels(seed, ("held",) * 3)
    return random_robot(seed, random_parents(random, 7), slides.tolist(), wheels)


ROBOTS = {f"random-{seed}": some_robot(seed) for seed in range(5)} | {
    "no wheels": random_robot(1, (0, 1), (1,)),
    "no joints": random_robot(2, (), (), random_wheels(2, ("held",) * 2)),
    "dual-arm": load_robot("dual-arm"),
    "cepheus-like": load_robot("cepheus-like"),
}


class Case(NamedTuple):
    """A robot in a state, with what either side makes of it."""

    robot: Robot
    q: np.ndarray
    v: np.ndarray
    ours: Equations
    theirs: "Theirs"


class Theirs(NamedTuple):
    """Pinocchio's, over the paper's speeds."""

    robot: PinocchioRobot
    data: pin.Data
    T: np.ndarray
    """Pinocchio's rates, in orbident's order, are `T v`."""
    H: np.ndarray
    c: np.ndarray
    a_S: np.ndarray
    """Acceleration of S at `v' = 0`."""


def theirs_of(robot: Robot, q: np.ndarray, v: np.ndarray) -> Theirs:
    pinocchio = pinocchio_model(wheels_as_joints(robot))
    model, rows = pinocchio.model, pinocchio.rows
    data = model.createData()
    at = pinocchio.q(np.append(q, np.zeros(len(robot.wheels))))
    pin.jacobianCenterOfMass(model, data, at)
    T = np.eye(v.size)
    T[:3, 3:] = -data.Jcom[:, rows[3:]]
    rates = np.zeros(model.nv)
    rates[rows] = T @ v
    upper = np.triu(pin.crba(model, data, at))
    H = (upper + np.triu(upper, 1).T)[np.ix_(rows, rows)]
    # Where v' = 0 the CM still turns with the base: a_cm = w x v_cm.
    pin.centerOfMass(model, data, at, rates, np.zeros(model.nv))
    drift = np.zeros(v.size)
    drift[:3] = np.cross(v[3:6], v[:3]) - data.acom[0]
    c = H @ drift + pin.nonLinearEffects(model, data, at, rates)[rows]
    a_S = drift[:3] + np.cross(v[3:6], (T @ v)[:3])
    pin.computeJointJacobians(model, data, at)
    return Theirs(pinocchio, data, T, T.T @ H @ T, T.T @ c, a_S)


@pytest.fixture(scope="module", params=ROBOTS)
def cases(request) -> list[Case]:
    """The robot in random states, wheels at hundreds of rad/s."""
    robot = ROBOTS[request.param]
    random = np.random.default_rng(7)
    cases = []
    for _ in range(STATES):
        q = random.standard_normal(len(robot.joints))
        v = random.standard_normal(6 + q.size + len(robot.wheels))
        v[6 + q.size :] *= 200.0
        every = equations_of_motion(robot, q[None], v[None])
        ours = Equations(*(part[0] for part in every))
        cases.append(Case(robot, q, v, ours, theirs_of(robot, q, v)))
    return cases


def assert_close(ours, theirs):
    scale = np.abs(theirs).max(initial=0.0)
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=TOLERANCE * scale)


def test_system_inertia_matrix(cases):
    for case in cases:
        assert_close(case.ours.H, case.theirs.H)


def test_velocity_dependent_forces(cases):
    for case in cases:
        assert_close(case.ours.c, case.theirs.c)


def test_many_states_at_once(cases):
    """On one thread and on two: the same bits."""
    q, v = (np.repeat([getattr(case, name) for case in cases], 60, 0) for name in "qv")
    robot = core_robot(cases[0].robot)
    one, two = (_core.equations_of_motion(robot, q, v, threads) for threads in (1, 2))
    for a, b, name in zip(one, two, Equations._fields, strict=True):
        np.testing.assert_array_equal(a, b)
        alone = np.array([getattr(case.ours, name) for case in cases])
        np.testing.assert_array_equal(a[::60], alone)


def test_feature_point(cases):
    """Its Jacobian, and its acceleration where `v' = 0`."""
    for case in cases:
        assert_close(velocity_of_S(case.robot, case.q), case.theirs.T[:6])
        assert_close(case.ours.f_S, case.theirs.a_S)


def test_point_jacobians(cases):
    """`J_0,p` and `J_i,p` of a random point of three bodies (A.1, A.2)."""
    case = cases[0]
    point = np.random.default_rng(1).standard_normal(3)
    for body in {0, (case.q.size + 1) // 2, case.q.size}:
        J = pin.getFrameJacobian(
            case.theirs.robot.model,
            case.theirs.data,
            case.theirs.robot.bodies[body],
            pin.SE3(np.eye(3), point),
            pin.LOCAL_WORLD_ALIGNED,
        )[:, case.theirs.robot.rows]
        ours = jacobian(case.robot, case.q, case.robot.bodies[body], point)
        assert_close(ours, J @ case.theirs.T)
