"""Free flying agrees with MuJoCo, which integrates every body and wheel by itself.

Thrusters pulse, joints follow sines under PD control, wheels are driven to speeds. The
edges of the pulses are among MuJoCo's steps. What remains between the two is MuJoCo's
integration error: it falls with the fourth power of its time step.
"""

# MuJoCo is compiled, and its stubs do not say what it exports.
# pyright: reportAttributeAccessIssue=false

from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import mujoco
import numpy as np
import pytest
from flying_robots import random_thrusters
from mujoco_model import mujoco_model
from obvious_momentum import quaternion_rotation
from random_robots import (
    DUAL_ARM,
    random_robot,
    random_start,
    random_swing,
    random_wheels,
)

from orbident.robot.description import Robot
from orbident.simulation.flight import FlyingState, JointPD, WheelSpeed, standing
from orbident.simulation.free_flying import FreeFlying, free_flying
from orbident.simulation.outside import Pulse

END = 2.0
STEPS = (0.04, 0.02, 0.01)
PULSES = (Pulse("t1", 0.4, 1.2, 6.0), Pulse("t2", 0.8, 1.6, 4.0))


def servicer() -> Robot:
    """Two arms, one joint sliding, three wheels and two thrusters, S off the link's
    origin."""
    wheels = random_wheels(1, ("free",) * 3)
    robot = random_robot(3, DUAL_ARM, prismatic=(4,), wheels=wheels, base=10.0)
    return replace(
        robot,
        thrusters=random_thrusters(4, ("t1", "t2")),
        feature_point=np.array([0.3, -0.2, 0.1]),
    )


ROBOT = servicer()
SWING = random_swing(6, 6)
JOINTS = JointPD(Kp=np.full(6, 20.0), Kd=np.full(6, 10.0))
WHEELS = WheelSpeed(k=np.full(3, 0.02), speed=np.array([150.0, -80.0, 40.0]))


class MujocoRun(NamedTuple):
    """What MuJoCo made of a run, at each of its steps."""

    q: np.ndarray
    qd: np.ndarray
    attitude: np.ndarray
    """Scalar last."""
    w: np.ndarray
    r_S: np.ndarray
    v_S: np.ndarray
    q_rw: np.ndarray
    qd_rw: np.ndarray
    qdd: np.ndarray
    w_dot: np.ndarray


class Plant:
    """The same laws and thrusters, in MuJoCo's coordinates."""

    def __init__(self, model: mujoco.MjModel, dt: float):
        self.joints = [model.joint(name).dofadr[0] for name in ROBOT.joint_names]
        self.wheels = [model.joint(name).dofadr[0] for name in ROBOT.wheel_names]
        self.dt, self.step = dt, 0

    def __call__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        q, qd, _ = SWING.at(np.array([data.time]))
        # The free joint has one position more than rates.
        e = q[0] - data.qpos[np.array(self.joints) + 1]
        e_d = qd[0] - data.qvel[self.joints]
        data.qfrc_applied[self.joints] = JOINTS.Kp * e + JOINTS.Kd * e_d
        slow = WHEELS.speed - data.qvel[self.wheels]
        data.qfrc_applied[self.wheels] = WHEELS.k * slow
        # Of the step as a whole: its last stage is at an edge already.
        middle = (self.step + 0.5) * self.dt
        force, moment = np.zeros(3), np.zeros(3)
        for thruster, pulse in zip(ROBOT.thrusters, PULSES, strict=True):
            if pulse.on < middle < pulse.off:
                push = pulse.force * thruster.direction
                force += push
                moment += np.cross(thruster.position - ROBOT.feature_point, push)
        # The free joint's force is in inertial axes, its moment in the body's.
        data.qfrc_applied[:3] = data.xmat[1].reshape(3, 3) @ force
        data.qfrc_applied[3:6] = moment


def start() -> FlyingState:
    """Tumbling, the joints off their command."""
    q, qd, _ = SWING.at(np.zeros(1))
    state = standing(random_start(8, ROBOT), q[0] + 0.1)
    return state._replace(qd=qd[0])


def mujoco_run(dt: float) -> MujocoRun:
    state = start()
    wheel_positions = 0.3 * np.random.default_rng(5).standard_normal((3, 3))
    model = mujoco_model(ROBOT, wheel_positions)
    model.opt.timestep = dt
    data, plant = mujoco.MjData(model), Plant(model, dt)
    joints, wheels = np.array(plant.joints), np.array(plant.wheels)
    data.qpos[3:7] = np.roll(state.base.attitude, 1)
    data.qpos[joints + 1] = state.q
    data.qvel[:3] = state.base.velocity
    data.qvel[3:6] = state.base.angular_velocity
    data.qvel[joints] = state.qd
    data.qvel[wheels] = state.base.wheel_speed
    rows = []
    mujoco.set_mjcb_control(plant)
    try:
        for plant.step in range(round(END / dt) + 1):
            mujoco.mj_forward(model, data)
            x, v, a = data.qpos.copy(), data.qvel.copy(), data.qacc.copy()
            rows.append(
                MujocoRun(
                    q=x[joints + 1],
                    qd=v[joints],
                    attitude=np.roll(x[3:7], -1),
                    w=v[3:6],
                    r_S=x[:3],
                    v_S=v[:3],
                    q_rw=x[wheels + 1],
                    qd_rw=v[wheels],
                    qdd=a[joints],
                    w_dot=a[3:6],
                )
            )
            mujoco.mj_step(model, data)
    finally:
        mujoco.set_mjcb_control(None)
    return MujocoRun(*(np.stack(column) for column in zip(*rows, strict=True)))


@pytest.fixture(scope="module")
def flown() -> FreeFlying:
    """Our flight, sampled at the finest of MuJoCo's steps."""
    t = np.arange(round(END / STEPS[-1]) + 1) * STEPS[-1]
    return free_flying(
        ROBOT, t, start(), SWING, JOINTS, WHEELS, pulses=PULSES, tolerance=1e-11
    )


def differences(theirs: MujocoRun, ours: FreeFlying, stride: int) -> dict[str, float]:
    """The largest of each, SI units."""
    R = [
        quaternion_rotation(a).T @ quaternion_rotation(b)
        for a, b in zip(theirs.attitude, ours.attitude[::stride], strict=True)
    ]
    found = {"attitude": np.linalg.norm(np.array(R) - np.eye(3), axis=(1, 2)).max()}
    for name in ("q", "qd", "w", "r_S", "v_S", "q_rw", "qd_rw", "qdd", "w_dot"):
        mine = getattr(ours, name)[::stride]
        found[name] = np.abs(getattr(theirs, name) - mine).max()
    return found


def test_the_run_has_everything_at_work(flown):
    assert np.abs(flown.tau).max() > 1.0
    assert np.abs(flown.tau_rw).max() > 1.0
    assert np.ptp(flown.v_cm, axis=0).max() > 0.05
    assert np.ptp(flown.w, axis=0).max() > 0.3


def test_motion_differs_by_mujocos_integration_error(flown):
    """The largest differences over 2 s:

    | dt, s | w, rad/s | attitude, rad | q, rad | r_S, m  | wheels, rad/s |
    |-------|----------|---------------|--------|---------|---------------|
    | 0.04  | 1.1e-6   | 2.4e-7        | 1.7e-6 | 1.0e-7  | 7.3e-7        |
    | 0.02  | 6.2e-8   | 1.4e-8        | 9.3e-8 | 5.6e-9  | 4.2e-8        |
    | 0.01  | 3.7e-9   | 8.0e-10       | 5.5e-9 | 3.4e-10 | 2.5e-9        |
    """
    runs = [mujoco_run(dt) for dt in STEPS]
    found = [
        differences(run, flown, round(dt / STEPS[-1]))
        for run, dt in zip(runs, STEPS, strict=True)
    ]
    # Twice what was observed, of the joints' accelerations.
    assert max(found[0].values()) < 1.6e-4
    for quantity in found[0]:
        for coarse, fine in pairwise(found):
            # The error of RK4 falls by 2^4. Observed: 16.4 to 17.9.
            assert 15 < coarse[quantity] / fine[quantity] < 19, quantity
