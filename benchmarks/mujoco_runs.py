"""The same free-floating motion by MuJoCo, which steps every body (RK4).

`Servoed` is how MuJoCo is driven as a rule: computed torques and PD in a control
callback. `Prescribed` is the fastest way found: no control law, no Python in the loop.
"""

# MuJoCo is compiled, and its stubs do not say what it exports.
# pyright: reportAttributeAccessIssue=false

from typing import NamedTuple, Protocol

import mujoco
import mujoco.rollout
import numpy as np
from mujoco_model import WHEEL_MASS, about_axis, give_inertia

from orbident.robot.description import Robot
from orbident.robot.parameters import from_mass_com_inertia
from orbident.simulation.free_floating import BaseState, JointMotion

ARMATURE = 1e16
"""kg m^2. So heavy a rotor has the acceleration `force / ARMATURE` to rounding, and
MuJoCo gives it no momentum: the joint does what it is told and the base feels it."""

# None of what this motion needs: MuJoCo is not to pay for it.
OFF = ("CONSTRAINT", "CONTACT", "SPRING", "DAMPER", "GRAVITY", "WARMSTART", "SENSOR")


class Flight(NamedTuple):
    """A motion to reproduce."""

    robot: Robot
    motion: JointMotion
    t: np.ndarray
    """Equally spaced."""
    start: BaseState

    def nodes(self, per_sample: int) -> np.ndarray:
        """The samples, and times that part each interval equally."""
        steps = per_sample * (self.t.size - 1)
        return np.linspace(self.t[0], self.t[-1], steps + 1)


class Drive(Protocol):
    """A way to make MuJoCo's joints follow the motion."""

    def run(self, steps: int) -> np.ndarray:
        """The base's quaternions, scalar last, with so many steps a sample."""
        ...


def floating_model(robot: Robot, armature: float) -> mujoco.MjModel:
    """Free joint, hinges, and wheels whose mass is taken out of the base.

    A joint's actuator adds the integral of its control, times the armature.
    """
    spec = mujoco.MjSpec()
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
    for name in OFF:
        spec.option.disableflags |= getattr(mujoco.mjtDisableBit, f"mjDSBL_{name}")
    hinge = mujoco.mjtJoint.mjJNT_HINGE
    base = spec.worldbody.add_body(name=robot.bodies[0])
    base.add_freejoint()
    theta_0 = robot.theta[0]
    com = theta_0[1:4] / theta_0[0]
    for wheel in robot.wheels:
        I = about_axis(wheel.inertia, wheel.axis)
        theta_0 = theta_0 - from_mass_com_inertia(WHEEL_MASS, com, I)
        body = base.add_body(name=wheel.name, pos=com)
        body.add_joint(name=wheel.name, type=hinge, axis=wheel.axis, armature=armature)
        give_inertia(body, from_mass_com_inertia(WHEEL_MASS, np.zeros(3), I))
    give_inertia(base, theta_0)
    bodies = [base]
    for joint, theta_i in zip(robot.joints, robot.theta[1:], strict=True):
        quat = np.zeros(4)
        mujoco.mju_mat2Quat(quat, joint.R_PJ.ravel())
        body = bodies[joint.parent].add_body(pos=joint.p_PJ, quat=quat)
        body.add_joint(name=joint.name, type=hinge, axis=joint.axis, armature=armature)
        give_inertia(body, theta_i)
        bodies.append(body)
        actuator = spec.add_actuator(name=joint.name, target=joint.name)
        actuator.trntype = mujoco.mjtTrn.mjTRN_JOINT
        actuator.dyntype = mujoco.mjtDyn.mjDYN_INTEGRATOR
        actuator.gaintype = mujoco.mjtGain.mjGAIN_FIXED
        actuator.gainprm[0] = armature
    return spec.compile()


class MujocoFlight:
    """A flight's model, and its first state."""

    def __init__(self, flight: Flight, armature: float):
        robot = flight.robot
        self.flight = flight
        self.model = floating_model(robot, armature)
        self.data = mujoco.MjData(self.model)
        self.joints = [self.model.joint(n).dofadr[0] for n in robot.joint_names]
        self.wheels = [self.model.joint(n).dofadr[0] for n in robot.wheel_names]

    def reset(self, steps: int) -> None:
        """Go back to the start of the flight, with so many steps a sample."""
        model, data, flight = self.model, self.data, self.flight
        mujoco.mj_resetData(model, data)
        model.opt.timestep = (flight.t[1] - flight.t[0]) / steps
        q, qd, _ = flight.motion.at(flight.t[:1])
        data.qpos[3:7] = np.roll(flight.start.attitude, 1)
        # The free joint has one position more than rates.
        data.qpos[np.array(self.joints) + 1] = q[0]
        data.qvel[3:6] = flight.start.angular_velocity
        data.qvel[self.joints] = qd[0]
        data.qvel[self.wheels] = flight.start.wheel_speed


class Prescribed:
    """Joint motion by heavy armatures, cubic in each step, through `mujoco.rollout`."""

    CONTROL = mujoco.mjtState.mjSTATE_CTRL | mujoco.mjtState.mjSTATE_QFRC_APPLIED
    STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS

    def __init__(self, flight: Flight):
        self.mujoco = MujocoFlight(flight, ARMATURE)

    def run(self, steps: int) -> np.ndarray:
        model, data, flight = self.mujoco.model, self.mujoco.data, self.mujoco.flight
        self.mujoco.reset(steps)
        first = np.empty(mujoco.mj_stateSize(model, self.STATE))
        mujoco.mj_getState(model, data, first, self.STATE)
        control = self._control(steps)
        states, _ = mujoco.rollout.rollout(
            model, data, first[None], control[None], control_spec=int(self.CONTROL)
        )
        # Time comes before the positions.
        attitudes = np.asarray(states)[0, steps - 1 :: steps, 4:8]
        return np.vstack([flight.start.attitude, np.roll(attitudes, -1, axis=1)])

    def _control(self, steps: int) -> np.ndarray:
        """Accelerations, linear in each step, that meet all positions and rates."""
        flight, model = self.mujoco.flight, self.mujoco.model
        q, qd, _ = flight.motion.at(flight.nodes(steps))
        h = model.opt.timestep
        mean = np.diff(q, axis=0) / h
        start = (6 * mean - 4 * qd[:-1] - 2 * qd[1:]) / h
        slope = (6 * (qd[:-1] + qd[1:]) - 12 * mean) / h**2
        # The actuators integrate the slope all along; the rest is applied at once.
        carried = np.vstack([np.zeros_like(q[:1]), np.cumsum(slope * h, axis=0)[:-1]])
        control = np.zeros((len(slope), model.nu + model.nv))
        control[:, : model.nu] = slope
        columns = model.nu + np.array(self.mujoco.joints)
        control[:, columns] = ARMATURE * (start - carried)
        return control


class Servoed:
    """Joint motion by computed torque and PD, in a control callback.

    For commanded accelerations `a` of what is driven, `M a + c = tau` has the
    accelerations of the base and the torques as its unknowns.
    """

    KP, KD = 9.0, 6.0

    def __init__(self, flight: Flight):
        self.mujoco = MujocoFlight(flight, armature=0.0)
        model = self.mujoco.model
        self.driven = np.array([*self.mujoco.joints, *self.mujoco.wheels])
        self.positions = np.array(self.mujoco.joints) + 1
        self.M = np.zeros((model.nv, model.nv))
        self.per_second = 0.0
        self.commanded: tuple[np.ndarray, ...] = ()

    def run(self, steps: int) -> np.ndarray:
        model, data, flight = self.mujoco.model, self.mujoco.data, self.mujoco.flight
        self.mujoco.reset(steps)
        # RK4 asks at the ends and in the middle of a step.
        self.per_second = 2 / model.opt.timestep
        self.commanded = flight.motion.at(flight.nodes(2 * steps))
        attitudes = [flight.start.attitude]
        mujoco.set_mjcb_control(self._torques)
        try:
            for _ in flight.t[1:]:
                mujoco.mj_step(model, data, steps)
                attitudes.append(np.roll(data.qpos[3:7], -1))
        finally:
            mujoco.set_mjcb_control(None)
        return np.array(attitudes)

    def _torques(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        node = round(data.time * self.per_second)
        q, qd, qdd = (history[node] for history in self.commanded)
        joints, driven = self.mujoco.joints, self.driven
        a = np.zeros(model.nv)
        e, e_d = q - data.qpos[self.positions], qd - data.qvel[joints]
        a[joints] = qdd + self.KD * e_d + self.KP * e
        M, c = self.M, data.qfrc_bias
        mujoco.mj_fullM(model, data, M)
        a[:6] = np.linalg.solve(M[:6, :6], -c[:6] - M[:6, 6:] @ a[6:])
        data.qfrc_applied[driven] = (M @ a + c)[driven]
