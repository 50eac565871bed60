"""Passive joints in the simulator, beside MuJoCo on exact motions of arm and wheels."""

# MuJoCo is compiled, and its stubs do not say what it exports.
# pyright: reportAttributeAccessIssue=false

from dataclasses import replace

import mujoco
import numpy as np
from examples import EXAMPLES

from orbident.model.kinematics import springs_on
from orbident.robot.robot_file import load_robot
from orbident.simulation.simulate import made_along
from orbident.trajectories.trajectory import InitialState, Trajectory

EXAMPLE = EXAMPLES / "mujoco-panels"

STIFFNESS, DAMPING, CARRIED = 86.65, 0.27583, 8.78
"""What each panel in `satellite.xml` has: N m/rad, N m s/rad and kg m^2."""

DURATION, RATE, STEP = 10.0, 25.0, 0.01
"""s, Hz and s: MuJoCo's RK4 is wrong by 1e-9 rad then."""

KP, KD = 9.0, 6.0
"""1/s^2 and 1/s: against what rounding adds."""


def satellite():
    """As it is, and not as its file has it, whose panels are 20 % off."""
    robot = load_robot(EXAMPLE / "satellite.yaml")
    rate = np.sqrt(STIFFNESS / CARRIED)
    share = DAMPING / (2 * rate * CARRIED)
    passive = {
        name: each._replace(frequency=rate / (2 * np.pi), damping=share)
        for name, each in robot.passive.items()
    }
    return replace(robot, passive=passive)


def motion_for(robot):
    a, b = 0.15 * np.random.default_rng(0).standard_normal((2, 2, 3))
    still = np.zeros((2, 3))
    initial = InitialState(
        angular_velocity=np.array([0.01, 0.03, -0.02]),
        wheel_speed=dict(zip(robot.wheel_names, (150.0, -120.0, 100.0), strict=True)),
    )
    return Trajectory(DURATION, ("shoulder", "elbow"), a, b, still, still, initial)


class Plant:
    """MuJoCo's satellite: torques by which arm and wheels do as they are told."""

    def __init__(self, robot, motion):
        path = str(EXAMPLE / "satellite.xml")
        self.model, self.motion = mujoco.MjModel.from_xml_path(path), motion
        self.model.opt.timestep = STEP
        self.model.actuator_gainprm[:] = self.model.actuator_biasprm[:] = 0.0
        self.data = mujoco.MjData(self.model)
        named = [self.model.joint(x) for x in (*motion.joints, *robot.wheel_names)]
        self.driven = np.array([each.dofadr[0] for each in named])
        self.arm = np.array([each.qposadr[0] for each in named[:2]])
        panels = (self.model.joint(name) for name in robot.passive)
        self.panels = np.array([each.qposadr[0] for each in panels])
        self.left = np.setdiff1d(np.arange(self.model.nv), self.driven)
        self.M = np.zeros((self.model.nv, self.model.nv))
        q, qd, _ = (each[0] for each in motion.at(np.zeros(1)))
        self.data.qpos[self.arm] = q
        speeds = motion.initial.wheel_speeds(robot.wheel_names)
        self.data.qvel[self.driven] = [*qd, *speeds]
        self.data.qvel[3:6] = motion.initial.angular_velocity

    def __call__(self, model, data):
        t = np.array([min(data.time, DURATION)])
        q, qd, qdd = (each[0] for each in self.motion.at(t))
        left, driven, arm = self.left, self.driven, self.driven[:2]
        a = np.zeros(model.nv)
        a[arm] = qdd + KD * (qd - data.qvel[arm]) + KP * (q - data.qpos[self.arm])
        mujoco.mj_fullM(model, data, self.M)
        force, M = data.qfrc_passive - data.qfrc_bias, self.M
        rest = force[left] - M[np.ix_(left, driven)] @ a[driven]
        a[left] = np.linalg.solve(M[np.ix_(left, left)], rest)
        data.qfrc_applied[driven] = (M @ a - force)[driven]

    def flown(self):
        """Angles of panels, base rate, attitude and position at the samples."""
        every = round(1 / RATE / STEP)
        rows = []
        mujoco.set_mjcb_control(self)
        try:
            for k in range(round(DURATION / STEP) + 1):
                if k % every == 0:
                    data = self.data
                    x_WB = np.roll(data.qpos[3:7], -1)
                    seen = data.qpos[self.panels], data.qvel[3:6], x_WB, data.qpos[:3]
                    rows.append(np.concatenate(seen))
                mujoco.mj_step(self.model, self.data)
        finally:
            mujoco.set_mjcb_control(None)
        return np.split(np.array(rows), np.cumsum([2, 3, 4]), axis=1)


def test_panels_swing_as_in_mujoco():
    robot = satellite()
    k, c = springs_on(robot)
    np.testing.assert_allclose(k[2:], STIFFNESS, rtol=1e-12)
    np.testing.assert_allclose(c[2:], DAMPING, rtol=1e-12)
    motion = motion_for(robot)
    made = made_along(robot, motion, RATE, tolerance=1e-10)
    panels, w, attitude, r_S = Plant(robot, motion).flown()
    true = made.true
    for ours, theirs in (
        (true.q[:, 2:], panels),
        (true.gyro, w),
        (true.attitude, attitude),
        (true.position, r_S - r_S[0]),
    ):
        amplitude = np.abs(theirs).max()
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-6 * amplitude)
