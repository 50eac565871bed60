"""Free floating in the core, against momentum body by body, on random trees."""

import numpy as np
import pytest
from hypothesis import given
from obvious_momentum import quaternion_rotation, system_motion
from random_trees import SHAPES, tree_of
from reference import runge_kutta
from scipy.spatial.transform import Rotation

from orbident import _core
from orbident.model.core_robot import core_robot

pytestmark = pytest.mark.core

# Some tens of terms, and one division by the inertia: conditions of some hundreds.
ROUNDING = 1e-11


@given(SHAPES)
def test_base_rate_has_the_momentum(shape):
    """`h_rs + h_spin - D_free w = R_0^T h_cm` at `w = E R_0^T h_cm - b`; r_S, v_S."""
    robot, random = tree_of(**shape)
    n, joints = 5, len(robot.joints)
    planar = robot.motion == "planar"
    axes = [2] if planar else [0, 1, 2]
    q, qd = random.standard_normal((2, n, joints))
    h_cm, h_spin = random.standard_normal((n, 3)), random.standard_normal(3)
    x_WB = random.standard_normal((n, 4))
    if planar:
        h_cm[:, :2], x_WB[:, :2] = 0.0, 0.0
    x_WB /= np.linalg.norm(x_WB, axis=1, keepdims=True)
    axis = random.standard_normal(3)
    D_free = 1e-3 * np.outer(axis, axis)
    core = core_robot(robot)
    E, b = _core.floating_laws(core, q, qd, D_free, h_spin, planar)
    w, r_S, v_S = _core.floating_motion(core, q, qd, E, b, h_cm, x_WB)
    for k in range(n):
        R_WB = quaternion_rotation(x_WB[k])
        at = system_motion(robot, q[k], qd[k], w[k])
        h = at.h_rs + h_spin - D_free @ w[k]
        scale = 1.0 + np.abs(at.angular).max()
        left = (R_WB.T @ h_cm[k] - h)[axes]
        np.testing.assert_allclose(left, 0.0, atol=ROUNDING * scale)
        if planar:
            np.testing.assert_array_equal(w[k, :2], 0.0)
        np.testing.assert_allclose(
            r_S[k], -R_WB @ at.first_moment / robot.mass, atol=ROUNDING
        )
        moving = 1.0 + np.abs(w[k]).max()
        np.testing.assert_allclose(
            v_S[k], -R_WB @ at.linear / robot.mass, atol=ROUNDING * moving
        )


@given(SHAPES)
def test_rate_laws_are_floating_laws(shape):
    """The same from `D` and `D_q qd`."""
    robot, random = tree_of(**shape)
    q, qd = random.standard_normal((2, 3, len(robot.joints)))
    core, planar = core_robot(robot), robot.motion == "planar"
    D, D_q, *_ = _core.inertia(core, q)
    h_q = np.einsum("nij,nj->ni", D_q, qd)
    for found, expected in zip(
        _core.rate_laws(D, h_q, planar),
        _core.floating_laws(core, q, qd, np.zeros((3, 3)), np.zeros(3), planar),
        strict=True,
    ):
        scale = 1.0 + np.abs(expected).max()
        np.testing.assert_allclose(found, expected, atol=ROUNDING * scale)


@given(SHAPES)
def test_attitudes_are_runge_kuttas(shape):
    """The momentum is another at each node."""
    _, random = tree_of(**shape)
    substeps = int(random.choice([2, 4, 6]))
    t = np.cumsum(random.uniform(0.0, 0.1, int(random.integers(1, 7))))
    dt = np.repeat(np.diff(t) / substeps, substeps)
    nodes = 2 * dt.size + 1
    E, b = random.standard_normal((nodes, 3, 3)), random.standard_normal((nodes, 3))
    h_cm, x_WB = random.standard_normal((nodes, 3)), random.standard_normal(4)
    x_WB /= np.linalg.norm(x_WB)
    fine = runge_kutta.attitudes(E, b, h_cm, x_WB, dt)[::substeps]
    coarse = runge_kutta.attitudes(E[::2], b[::2], h_cm[::2], x_WB, 2 * dt[::2])
    coarse = coarse[:: substeps // 2]
    found, apart = _core.attitudes(E, b, h_cm, x_WB, t, substeps)
    np.testing.assert_allclose(found, fine, atol=1e-14)
    angles = (Rotation.from_quat(coarse).inv() * Rotation.from_quat(fine)).magnitude()
    np.testing.assert_allclose(apart, angles.max(), atol=1e-14)


@pytest.mark.parametrize("substeps", [-2, 0, 3])
def test_steps_that_have_no_halves_are_refused(substeps):
    E, b, x_WB = np.zeros((1, 3, 3)), np.zeros((1, 3)), np.zeros(4)
    with pytest.raises(ValueError, match="substeps"):
        _core.attitudes(E, b, b, x_WB, np.zeros(1), substeps)


def test_threads_change_no_bit():
    robot, random = tree_of(3, joints=4, wheels=2, planar=False, massless=False)
    q, qd = random.standard_normal((2, 1000, len(robot.joints)))
    D_free, h_spin = np.zeros((3, 3)), random.standard_normal(3)
    core = core_robot(robot)
    one, two = (
        _core.floating_laws(core, q, qd, D_free, h_spin, False, threads)
        for threads in (1, 2)
    )
    for a, b in zip(one, two, strict=True):
        np.testing.assert_array_equal(a, b)
    h_cm, x_WB = random.standard_normal((1000, 3)), random.standard_normal((1000, 4))
    one, two = (
        _core.floating_motion(core, q, qd, *one, h_cm, x_WB, threads)
        for threads in (1, 2)
    )
    for a, b in zip(one, two, strict=True):
        np.testing.assert_array_equal(a, b)
