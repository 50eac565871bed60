"""Where a scene puts its frames, its CM and its momentum agrees with Pinocchio."""

# Pinocchio is compiled and has no stubs.
# pyright: reportAttributeAccessIssue=false

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pinocchio as pin
import pytest
from pinocchio_model import pinocchio_model
from random_robots import random_parents, random_quaternion, random_robot, random_wheels
from scipy.spatial.transform import Rotation

from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import Robot
from orbident.scene.replay import (
    BasePose,
    MotionHistory,
    centroidal_momentum,
    inertia_ellipsoids,
    inertia_intervals,
    placed,
    reaction,
    tips,
)
from orbident.scene.scene import scene_of

TIMES, JOINTS = 5, 6
# Some tens of float64 products on either side.
ROUNDING = 1e-12


@pytest.fixture(params=range(4))
def robot(request: pytest.FixtureRequest) -> Robot:
    random = np.random.default_rng(request.param)
    parents = random_parents(random, JOINTS)
    wheels = random_wheels(request.param, ["held", "held"])
    return random_robot(request.param, parents, prismatic=[1], wheels=wheels)


def random_states(robot: Robot) -> MotionHistory:
    random = np.random.default_rng(7)
    q, qd = random.standard_normal((2, TIMES, JOINTS))
    w, r_S, v_S = random.standard_normal((3, TIMES, 3))
    x_WB = np.array([random_quaternion(random) for _ in range(TIMES)])
    qd_rw = random.standard_normal((TIMES, len(robot.wheels)))
    return MotionHistory(np.arange(TIMES, dtype=float), q, qd, x_WB, w, r_S, v_S, qd_rw)


def test_ellipsoids_have_the_inertia_of_the_system(robot: Robot):
    motion = random_states(robot)
    found = inertia_ellipsoids(robot, motion)
    theirs = pinocchio_model(robot)
    data = theirs.model.createData()
    for k in range(TIMES):
        q, v = theirs.q(motion.q[k]), theirs.v(motion.w[k], motion.qd[k])
        q[:7] = [*motion.r_S[k], *motion.x_WB[k]]
        pin.ccrba(theirs.model, data, q, v)
        # The mass is that of the system, too.
        even = pin.Inertia.FromEllipsoid(data.Ig.mass, *found.lengths[k])
        turned = found.R[k] @ even.inertia @ found.R[k].T
        assert np.linalg.det(found.R[k]) == pytest.approx(1.0)
        scale = np.abs(data.Ig.inertia).max()
        np.testing.assert_allclose(turned, data.Ig.inertia, atol=1e-11 * scale, rtol=0)
        np.testing.assert_allclose(found.r_cm[k], data.com[0], atol=ROUNDING * 10)


DRAWS = 2000


def test_intervals_of_half_axes_are_those_of_random_draws(robot: Robot):
    """Of robots drawn from the covariance, along the axes of the mean one."""
    random, motion = np.random.default_rng(3), random_states(robot)
    base = minimal_sets(robot).base
    size = base.T.shape[0]
    turn, _ = np.linalg.qr(random.standard_normal((size, size)))
    root = 0.003 * np.abs(base.T @ robot.theta.ravel())[:, None] * turn
    found = inertia_ellipsoids(robot, motion)
    low, high = inertia_intervals(robot, root, motion)
    R_WB = Rotation.from_quat(motion.x_WB).as_matrix()
    squares = np.empty((DRAWS, 3))
    for k in range(DRAWS):
        off = base.theta_of @ (root @ random.standard_normal(size))
        drawn = replace(robot, theta=robot.theta + off.reshape(robot.theta.shape))
        theirs = pinocchio_model(drawn)
        data = theirs.model.createData()
        q, v = theirs.q(motion.q[0]), theirs.v(motion.w[0], motion.qd[0])
        pin.ccrba(theirs.model, data, q, v)
        axes = R_WB[0].T @ found.R[0]
        moments = np.diag(axes.T @ data.Ig.inertia @ axes)
        squares[k] = 2.5 / data.Ig.mass * (moments.sum() - 2 * moments)
    std = (high.lengths**2 - low.lengths**2)[0] / (2 * 1.96)
    # The deviation of so many draws is known to 1/sqrt(2 DRAWS) = 1.6 %: four of these.
    assert np.allclose(std, squares.std(axis=0), rtol=0.064)
    middle = (high.lengths**2 + low.lengths**2) / 2
    assert np.allclose(middle, found.lengths**2, rtol=1e-9)


def test_tips_are_as_far_behind_the_cm_as_the_joint_is_before(robot: Robot):
    motion = random_states(robot)
    at = placed(scene_of(robot), motion, np.zeros((TIMES, len(robot.wheels))))
    theirs = pinocchio_model(robot)
    data, last = theirs.model.createData(), set(range(len(robot.bodies)))
    last -= {joint.parent for joint in robot.joints}
    found = tips(robot, at)
    assert set(found) == {f"tip of {robot.bodies[i]}" for i in last}
    for k in range(TIMES):
        q = theirs.q(motion.q[k])
        q[:7] = [*motion.r_S[k], *motion.x_WB[k]]
        pin.forwardKinematics(theirs.model, data, q)
        for i in last:
            lever = theirs.model.inertias[theirs.bodies[i]].lever
            end = data.oMi[theirs.bodies[i]].act(2 * lever)
            off = found[f"tip of {robot.bodies[i]}"][k] - end
            assert np.abs(off).max() < ROUNDING


def test_frames_cm_and_momentum(robot: Robot):
    motion = random_states(robot)
    at = placed(scene_of(robot), motion, motion.wheel_angles())
    found = centroidal_momentum(robot, motion)
    theirs = pinocchio_model(robot)
    data = theirs.model.createData()
    for k in range(TIMES):
        R_WB = Rotation.from_quat(motion.x_WB[k]).as_matrix()
        q, v = theirs.q(motion.q[k]), theirs.v(motion.w[k], motion.qd[k])
        q[:7] = [*motion.r_S[k], *motion.x_WB[k]]
        v[:3] = R_WB.T @ motion.v_S[k]
        pin.forwardKinematics(theirs.model, data, q)
        for frame, joint in enumerate(theirs.bodies):
            there = data.oMi[joint]
            assert np.abs(at.R[k, frame] - there.rotation).max() < ROUNDING
            assert np.abs(at.p[k, frame] - there.translation).max() < ROUNDING
        total = pin.computeCentroidalMomentum(theirs.model, data, q, v)
        scale = 1 + np.abs(total.vector).max()
        assert np.abs(found.r_cm[k] - data.com[0]).max() < ROUNDING
        assert np.abs(found.p[k] - total.linear).max() < ROUNDING * scale
        assert np.abs(found.h_rs[k] - total.angular).max() < ROUNDING * scale


def test_a_base_that_answers_has_no_momentum(robot: Robot):
    """Over a short way, rates are differences: their momentum vanishes with it."""
    random = np.random.default_rng(3)
    q, way = random.standard_normal((2, JOINTS))
    before = BasePose(random_quaternion(random), random.standard_normal(3))
    step = 1e-3
    after = reaction(robot, before, q - step * way, q + step * way)
    theirs = pinocchio_model(robot)
    data = theirs.model.createData()
    ends = []
    for base, joints in ((before, q - step * way), (after, q + step * way)):
        configuration = theirs.q(joints)
        configuration[:7] = [*base.r_S, *base.x_WB]
        ends.append(configuration)
    middle = pin.interpolate(theirs.model, *ends, 0.5)
    v = pin.difference(theirs.model, *ends) / (2 * step)
    found = pin.computeCentroidalMomentum(theirs.model, data, middle, v).vector
    alone = v.copy()
    alone[:6] = 0.0
    of_joints = pin.computeCentroidalMomentum(theirs.model, data, middle, alone).vector
    # Central differences are of second order: 1e-6, times the curvature of the way.
    assert np.abs(found).max() < 1e-4 * np.abs(of_joints).max()


def test_the_cm_rests_and_the_way_matters(robot: Robot):
    q = np.zeros(JOINTS)
    start = BasePose(np.array([0.0, 0.0, 0.0, 1.0]), np.zeros(3))
    corners = [q, q + 0.8 * np.eye(JOINTS)[0], q + 0.8 * np.eye(JOINTS)[:3].sum(0), q]
    base, theirs = start, pinocchio_model(robot)
    data = theirs.model.createData()
    for a, b in pairwise(corners):
        base = reaction(robot, base, a, b)
        configuration = theirs.q(b)
        configuration[:7] = [*base.r_S, *base.x_WB]
        cm = pin.centerOfMass(theirs.model, data, configuration)
        first = pin.centerOfMass(theirs.model, data, theirs.q(q))
        # The attitude is integrated to 1e-9 rad; the CM follows from it.
        assert np.abs(cm - first).max() < 1e-7
    # The joints are back, the base is not: momentum conservation is nonholonomic.
    assert np.abs(base.x_WB[:3]).max() > 1e-3
    there = reaction(robot, start, q, corners[1])
    back = reaction(robot, there, corners[1], q)
    # The same way back undoes it, to the integrator's 1e-9 rad.
    assert np.abs(back.x_WB - start.x_WB).max() < 1e-7
