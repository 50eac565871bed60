"""The free-floating motion agrees with MuJoCo's, which integrates every body.

MuJoCo integrates all accelerations by RK4 at a fixed step. orbident is given the joint
motion that MuJoCo arrived at, and integrates the attitude alone. What remains between
them is MuJoCo's integration error: it falls with the fourth power of its time step.
"""

# MuJoCo is compiled, and its stubs do not say what it exports.
# pyright: reportAttributeAccessIssue=false

from itertools import pairwise
from typing import NamedTuple

import mujoco
import numpy as np
import pytest
from mujoco_model import mujoco_model
from obvious_momentum import quaternion_rotation
from random_robots import DUAL_ARM, random_quaternion, random_robot, random_wheels
from scipy.interpolate import CubicHermiteSpline

from orbident.model.core_robot import wheels_of
from orbident.model.kinematics import inertia_at
from orbident.robot.description import Robot
from orbident.simulation.free_floating import BaseState, FreeFloating, free_floating

DURATION = 4.0
STEPS = (0.04, 0.02, 0.01)
MODES = [("held",) * 3, ("free",) * 3, ("held", "free", "held")]


class MujocoRun(NamedTuple):
    """What MuJoCo made of a run, at each of its steps."""

    t: np.ndarray
    q: np.ndarray
    qd: np.ndarray
    attitude: np.ndarray
    """Scalar last."""
    w: np.ndarray
    r_S: np.ndarray
    v_S: np.ndarray
    qd_rw: np.ndarray
    h_cm: np.ndarray
    """MuJoCo's own angular momentum about the system CM, inertial axes."""
    v_cm: np.ndarray
    """MuJoCo's own velocity of the system CM, inertial axes."""


class Interpolated(NamedTuple):
    """MuJoCo's joints as a function of time, from its positions and rates."""

    curve: CubicHermiteSpline

    def at(self, t):
        return self.curve(t), self.curve(t, 1), self.curve(t, 2)


def servicer(modes) -> Robot:
    """Two arms of three joints, one sliding, and three wheels on a light base."""
    wheels = random_wheels(1, modes)
    return random_robot(3, DUAL_ARM, prismatic=(4,), wheels=wheels, base=10.0)


def commanded(t: float, joints: int):
    """Positions, rates and accelerations that the joints are to follow."""
    k = np.arange(joints)
    rate, phase = 0.8 + 0.3 * k, 1.7 * k
    angle = rate * t + phase
    q, qd = 0.5 * np.sin(angle), 0.5 * rate * np.cos(angle)
    return q, qd, -(rate**2) * q


class Controller:
    """Feedforward and PD on the joints; free wheels and the base get no torque.

    For commanded accelerations `a_a` of what is driven, `M a + c = tau` has the
    accelerations of the rest and the torques as its unknowns. A held wheel is
    commanded none.
    """

    KP, KD = 9.0, 6.0

    def __init__(self, model: mujoco.MjModel, robot: Robot):
        self.joints = [model.joint(name).dofadr[0] for name in robot.joint_names]
        self.wheels = [model.joint(name).dofadr[0] for name in robot.wheel_names]
        held = [
            dof
            for dof, wheel in zip(self.wheels, robot.wheels, strict=True)
            if wheel.mode == "held"
        ]
        self.driven = np.array([*self.joints, *held])
        self.left = np.setdiff1d(np.arange(model.nv), self.driven)
        self.M = np.zeros((model.nv, model.nv))

    def __call__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        a = np.zeros(model.nv)
        q, qd, qdd = commanded(data.time, len(self.joints))
        # The free joint has one position more than rates.
        e = q - data.qpos[np.array(self.joints) + 1]
        e_d = qd - data.qvel[self.joints]
        a[self.joints] = qdd + self.KD * e_d + self.KP * e
        mujoco.mj_fullM(model, data, self.M)
        left, driven = self.left, self.driven
        force = -data.qfrc_bias[left] - self.M[np.ix_(left, driven)] @ a[driven]
        a[left] = np.linalg.solve(self.M[np.ix_(left, left)], force)
        data.qfrc_applied[driven] = (self.M @ a + data.qfrc_bias)[driven]


def mujoco_run(robot: Robot, dt: float) -> MujocoRun:
    """A run from a tumbling start with spinning wheels, joints off their command."""
    random = np.random.default_rng(5)
    model = mujoco_model(robot, 0.3 * random.standard_normal((len(robot.wheels), 3)))
    model.opt.timestep = dt
    data, control = mujoco.MjData(model), Controller(model, robot)
    q, qd, _ = commanded(0.0, len(robot.joints))
    data.qpos[3:7] = np.roll(random_quaternion(random), 1)
    data.qpos[np.array(control.joints) + 1] = q + 0.1 * random.standard_normal(q.size)
    data.qvel[:6] = 0.3 * random.standard_normal(6)
    data.qvel[control.joints] = qd
    data.qvel[control.wheels] = 200.0 * random.standard_normal(len(robot.wheels))
    rows = []
    mujoco.set_mjcb_control(control)
    try:
        for _ in range(round(DURATION / dt) + 1):
            mujoco.mj_forward(model, data)
            mujoco.mj_subtreeVel(model, data)
            x, v = data.qpos.copy(), data.qvel.copy()
            rows.append(
                MujocoRun(
                    t=np.array(data.time),
                    q=x[np.array(control.joints) + 1],
                    qd=v[control.joints],
                    attitude=np.roll(x[3:7], -1),
                    w=v[3:6],
                    r_S=x[:3],
                    v_S=v[:3],
                    qd_rw=v[control.wheels],
                    h_cm=data.subtree_angmom[1].copy(),
                    v_cm=data.subtree_linvel[1].copy(),
                )
            )
            mujoco.mj_step(model, data)
    finally:
        mujoco.set_mjcb_control(None)
    return MujocoRun(*(np.stack(column) for column in zip(*rows, strict=True)))


def floated(robot: Robot, theirs: MujocoRun) -> FreeFloating:
    """orbident's motion from the same start, with the joints that MuJoCo realised."""
    start = BaseState(theirs.w[0], theirs.attitude[0], theirs.v_S[0], theirs.qd_rw[0])
    motion = Interpolated(CubicHermiteSpline(theirs.t, theirs.q, theirs.qd))
    return free_floating(robot, motion, theirs.t, start, tolerance=1e-11)


def differences(theirs: MujocoRun, ours: FreeFloating) -> dict[str, float]:
    """The largest of each: rad/s, rad, m, m/s, rad/s."""
    R = [
        quaternion_rotation(a).T @ quaternion_rotation(b)
        for a, b in zip(theirs.attitude, ours.attitude, strict=True)
    ]
    # The chordal distance of a small angle is sqrt(2) of it.
    angle = np.linalg.norm(np.array(R) - np.eye(3), axis=(1, 2)) / np.sqrt(2)
    return {
        "w": np.abs(theirs.w - ours.w).max(),
        "attitude": angle.max(),
        "r_S": np.abs(theirs.r_S - theirs.r_S[0] - ours.r_S).max(),
        "v_S": np.abs(theirs.v_S - ours.v_S).max(),
        "qd_rw": np.abs(theirs.qd_rw - ours.qd_rw).max(),
    }


@pytest.fixture(scope="module", params=MODES, ids="-".join)
def robot(request) -> Robot:
    return servicer(request.param)


@pytest.fixture(scope="module")
def runs(robot) -> list[MujocoRun]:
    """The same start with MuJoCo's time step halved twice."""
    return [mujoco_run(robot, dt) for dt in STEPS]


def test_wheels_are_counted_once(robot):
    """MuJoCo's bodies, the wheels among them, weigh what the robot does."""
    model = mujoco_model(robot, np.zeros((len(robot.wheels), 3)))
    assert model.nbody == 1 + len(robot.bodies) + len(robot.wheels)
    # Three subtractions and additions of kilograms, in float64.
    np.testing.assert_allclose(model.body_mass.sum(), robot.mass, rtol=1e-14)


def test_momentum_of_every_state_is_mujocos(robot, runs):
    """No integration enters: both sides see MuJoCo's state."""
    wheels = wheels_of(robot)
    for state in zip(*runs[0], strict=True):
        _, q, qd, x_WB, w, _, v_S, qd_rw, h_cm, v_cm = state
        at = inertia_at(robot, q)
        R_WB = quaternion_rotation(x_WB)
        h = R_WB @ (at.D @ w + at.D_q @ qd + wheels.A_rw @ qd_rw)
        v = v_S + R_WB @ (np.cross(w, at.r_cm) + at.J_cm @ qd)
        # Sums of some tens of float64 terms; the worst observed is 5e-15.
        assert np.linalg.norm(h - h_cm) < 1e-12 * np.linalg.norm(h)
        assert np.linalg.norm(v - v_cm) < 1e-12 * np.linalg.norm(v)


def test_motion_differs_by_mujocos_integration_error(robot, runs):
    """The largest differences over 4 s, at base rates up to 0.72 rad/s (all modes):

    | dt, s | w, rad/s | attitude, rad | r_S, m | v_S, m/s | free wheels, rad/s |
    |-------|----------|---------------|--------|----------|--------------------|
    | 0.04  | 3.6e-7   | 7.6e-7        | 6.1e-7 | 2.6e-7   | 3.0e-7             |
    | 0.02  | 2.2e-8   | 4.6e-8        | 3.7e-8 | 1.6e-8   | 1.8e-8             |
    | 0.01  | 1.4e-9   | 2.9e-9        | 2.3e-9 | 9.7e-10  | 1.2e-9             |
    """
    found = [differences(run, floated(robot, run)) for run in runs]
    for quantity, coarsest in found[0].items():
        if quantity == "qd_rw" and all(wheel.mode == "held" for wheel in robot.wheels):
            continue
        # Twice what was observed.
        assert coarsest < 1.6e-6
        for coarse, fine in pairwise(found):
            # RK4: 2^4. Observed: 16.0 to 16.6.
            assert 14 < coarse[quantity] / fine[quantity] < 18, quantity
    # A held wheel keeps its speed in both, whatever the step.
    held = [wheel.mode == "held" for wheel in robot.wheels]
    for run in runs:
        np.testing.assert_allclose(
            run.qd_rw[:, held], floated(robot, run).qd_rw[:, held], rtol=1e-12
        )
