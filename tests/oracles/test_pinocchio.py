"""Every quantity of the model agrees with Pinocchio, on random trees."""

# Pinocchio is compiled and has no stubs.
# pyright: reportAttributeAccessIssue=false

from typing import NamedTuple

import numpy as np
import pinocchio as pin
import pytest
from one_state import only_state
from pinocchio_model import PinocchioRobot, pinocchio_model
from random_robots import random_parents, random_robot

from orbident import _core
from orbident.model.core_robot import core_robot
from orbident.model.equations_of_motion import jacobian, velocity_of_S
from orbident.model.kinematics import (
    Inertia,
    MomentumRegressors,
    Poses,
    inertia_at,
    momentum_regressors,
    poses,
)
from orbident.robot.description import Robot

pytestmark = pytest.mark.core

ROBOTS, STATES, JOINTS = 24, 4, 7

# Both sides multiply some tens of float64 matrices: 1e-15 each, and seldom in step.
# Relative to the largest entry of the quantity; the worst observed is 3e-15.
TOLERANCE = 1e-12


class Masses(NamedTuple):
    """Mass, first moment and inertia of some bodies about S, base axes."""

    m: np.ndarray
    s: np.ndarray
    J: np.ndarray


class Ours(NamedTuple):
    """Everything orbident computes for one case."""

    poses: Poses
    masses: Masses
    carried: Masses
    inertia: Inertia
    momentum: MomentumRegressors


class Case(NamedTuple):
    """A robot in a state, with what either side makes of it."""

    robot: Robot
    ours: Ours
    theirs: PinocchioRobot
    data: pin.Data
    q: np.ndarray
    v: np.ndarray
    """Pinocchio's configuration and velocity."""


def ours_of(robot: Robot, q: np.ndarray, qd: np.ndarray, w: np.ndarray) -> Ours:
    """One state, without the leading axis of the states."""
    return Ours(
        only_state(poses(robot, q[None])),
        only_state(Masses(*_core.masses(core_robot(robot), q[None], False))),
        only_state(Masses(*_core.masses(core_robot(robot), q[None], True))),
        inertia_at(robot, q),
        only_state(momentum_regressors(robot, q[None], qd[None], w[None])),
    )


def some_robot(seed: int) -> Robot:
    random = np.random.default_rng(seed)
    parents = random_parents(random, JOINTS)
    slides = np.flatnonzero(random.random(JOINTS) < 0.3)
    return random_robot(seed, parents, slides.tolist())


@pytest.fixture(scope="module")
def cases() -> list[Case]:
    """Each robot in several states."""
    robots = [some_robot(seed) for seed in range(ROBOTS) for _ in range(STATES)]
    random = np.random.default_rng(0)
    q, qd = random.standard_normal((2, len(robots), JOINTS))
    w = random.standard_normal((len(robots), 3))
    cases = []
    for k, robot in enumerate(robots):
        theirs = pinocchio_model(robot)
        data = theirs.model.createData()
        at, rate = theirs.q(q[k]), theirs.v(w[k], qd[k])
        pin.forwardKinematics(theirs.model, data, at, rate)
        # Fills oYcrb, J, Ag, Ig and hg; S is Pinocchio's world origin.
        pin.ccrba(theirs.model, data, at, rate)
        pin.jacobianCenterOfMass(theirs.model, data, at)
        mine = ours_of(robot, q[k], qd[k], w[k])
        cases.append(Case(robot, mine, theirs, data, at, rate))
    return cases


def assert_close(ours, theirs):
    np.testing.assert_allclose(
        ours, theirs, rtol=0, atol=TOLERANCE * np.abs(theirs).max()
    )


def joint_space_inertia(case: Case) -> np.ndarray:
    """Over `[v_S, w, qd]`, in orbident's order of the joints."""
    model = case.theirs.model
    upper = np.triu(pin.crba(model, model.createData(), case.q))
    H = upper + np.triu(upper, 1).T
    return H[np.ix_(case.theirs.rows, case.theirs.rows)]


def test_robots_have_sliding_joints_and_several_arms(cases):
    kinds = {joint.kind for case in cases for joint in case.robot.joints}
    assert kinds == {"revolute", "prismatic"}
    for case in cases:
        assert [joint.parent for joint in case.robot.joints].count(0) >= 2


def test_body_poses(cases):
    for case in cases:
        placed = [case.data.oMi[i] for i in case.theirs.bodies]
        assert_close(case.ours.poses.R, np.array([M.rotation for M in placed]))
        assert_close(case.ours.poses.d, np.array([M.translation for M in placed]))


def test_joint_fields(cases):
    for case in cases:
        J = case.data.J[:, case.theirs.rows[6:]].T
        assert_close(case.ours.poses.field_u, J[:, :3])
        assert_close(case.ours.poses.field_w, J[:, 3:])


def test_body_velocities(cases):
    for case in cases:
        moving = [
            (case.data.oMi[i].rotation, case.data.v[i]) for i in case.theirs.bodies
        ]
        v = np.array([R @ twist.linear for R, twist in moving])
        w = np.array([R @ twist.angular for R, twist in moving])
        # A body's column of mass is v_i, those of its first moment are w_i x r_j along
        # its axes r_j; and the sum of r_j x (w x r_j) is 2 w.
        P = case.ours.momentum.P.reshape(3, -1, 10)
        assert_close(P[:, :, 0].T, v)
        turned = np.moveaxis(P[:, :, 1:4], 1, 0)
        r = case.ours.poses.R
        assert_close(np.cross(r, turned, axis=1).sum(axis=2) / 2, w)


def test_each_body_about_S(cases):
    for case in cases:
        model = case.theirs.model
        at_S = [case.data.oMi[i].act(model.inertias[i]) for i in case.theirs.bodies]
        assert_close(case.ours.masses.m, np.array([Y.mass for Y in at_S]))
        assert_close(case.ours.masses.s, np.array([Y.mass * Y.lever for Y in at_S]))
        assert_close(case.ours.masses.J, np.array([Y.matrix()[3:, 3:] for Y in at_S]))


def test_composite_of_what_each_joint_carries(cases):
    for case in cases:
        composites = [case.data.oYcrb[i] for i in case.theirs.bodies[1:]]
        ours = case.ours.carried
        carried = np.array([Y.mass * Y.lever for Y in composites])
        assert_close(ours.m[1:], np.array([Y.mass for Y in composites]))
        assert_close(ours.s[1:], carried)
        assert_close(ours.J[1:], np.array([Y.matrix()[3:, 3:] for Y in composites]))


def test_inertia_is_the_schur_complement_of_the_joint_space_inertia(cases):
    """`H` over `[v_S, w, qd]`, with `v_S` eliminated."""
    for case in cases:
        H = joint_space_inertia(case)
        C = H[3:, 3:] - H[3:, :3] @ np.linalg.solve(H[:3, :3], H[:3, 3:])
        ours = case.ours.inertia
        assert_close(case.ours.carried.m[0], H[0, 0])
        assert_close(np.block([[ours.D, ours.D_q], [ours.D_q.T, ours.D_qq]]), C)


def test_inertia_is_centroidal(cases):
    """`D` and `D_q` again, by Pinocchio's own centroidal route."""
    for case in cases:
        assert_close(case.ours.inertia.D, case.data.Ig.inertia)
        assert_close(case.ours.inertia.D_q, case.data.Ag[3:, case.theirs.rows[6:]])


def test_system_cm_and_its_jacobian(cases):
    for case in cases:
        assert_close(case.ours.inertia.r_cm, case.data.com[0])
        assert_close(case.ours.inertia.J_cm, case.data.Jcom[:, case.theirs.rows[6:]])


def test_momentum(cases):
    for case in cases:
        theta, ours = case.robot.theta.ravel(), case.ours.momentum
        S, P, A = ours.S @ theta, ours.P @ theta, ours.A @ theta
        M = case.robot.mass
        assert_close(S, M * case.data.com[0])
        assert_close(P, case.data.hg.linear)
        assert_close(A, (joint_space_inertia(case) @ case.v[case.theirs.rows])[3:6])
        assert_close(A - np.cross(S, P) / M, case.data.hg.angular)


def test_momentum_regressors(cases):
    """At zero velocity the force is `H a`: with `a = v`, the momentum."""
    for case in cases:
        model = case.theirs.model
        rows = pin.computeJointTorqueRegressor(
            model, model.createData(), case.q, np.zeros(model.nv), case.v
        )[:6]
        # Pinocchio's columns are in its own order of the bodies.
        columns = [10 * (i - 1) + k for i in case.theirs.bodies for k in range(10)]
        assert_close(case.ours.momentum.P, rows[:3, columns])
        assert_close(case.ours.momentum.A, rows[3:, columns])


def test_point_jacobian_of_every_body(cases):
    """The bodies are the base, those in the middle, and all tips."""
    points = np.random.default_rng(1).standard_normal((len(cases), 3))
    for case, point in zip(cases, points, strict=True):
        q = case.q[case.theirs.rows[6:] + 1]
        for body, index in enumerate(case.theirs.bodies):
            J = pin.getFrameJacobian(
                case.theirs.model,
                case.data,
                index,
                pin.SE3(np.eye(3), point),
                pin.LOCAL_WORLD_ALIGNED,
            )
            # The part over the base rate and the joints' rates, of the motion from S.
            ours = jacobian(case.robot, q, case.robot.bodies[body], point)
            ours[:3] -= velocity_of_S(case.robot, q)[:3]
            ours = ours[:, 3:]
            assert_close(ours, J[:, case.theirs.rows[3:]])
