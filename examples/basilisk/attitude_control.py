"""A module for Basilisk: wheels turn the hub as planned, whatever its arm does.

In hub axes, with the momentum `h_rs = D w + D_q qd` of hub and arm and `h_rw` of the
wheels, both about the CM, no external torque acts:

    d(h_rs)/dt + d(h_rw)/dt + w x (h_rs + h_rw) = 0

So the torque on the wheels is what the planned motion of arm and hub takes from
`h_rs`, and a correction of the attitude:

    u = -d(h_rs)/dt - w x (h_rs + h_rw) + D (k_e e + k_w (w - w_planned))
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from Basilisk.architecture import messaging, sysModel
from scipy.spatial.transform import Rotation

from orbident.model.kinematics import inertia_at
from orbident.robot.description import Robot

BANDWIDTH, DAMPING = 0.3, 0.8
"""Bandwidth of the correction in rad/s, and its damping over the critical one."""
SHORT = 0.005
"""s, of the differences that rates are made of."""


class Plan(NamedTuple):
    """What arm and hub are to do, by time in s."""

    joints: Callable[[float], tuple[np.ndarray, np.ndarray]]
    """Positions and rates."""
    attitude: Callable[[float], Rotation]
    """Attitude of the hub in inertial axes."""

    def rate(self, t: float) -> np.ndarray:
        """Angular velocity of the hub in hub axes, rad/s."""
        now, later = self.attitude(t), self.attitude(t + SHORT)
        return (now.inv() * later).as_rotvec() / SHORT


class AttitudeControl(sysModel.SysModel):
    """Subscribe `scStateInMsg`, `rwSpeedInMsg` and every one of `jointInMsgs`."""

    def __init__(self, plan: Plan, known: Callable[[], Robot]) -> None:
        """Control by what is known of the robot.

        Args:
            plan: of arm and hub.
            known: gives the robot with the parameters that are believed now; its wheels
                are along the hub's axes.
        """
        super().__init__()
        self.ModelTag = "attitudeControl"
        self.scStateInMsg = messaging.SCStatesMsgReader()
        self.rwSpeedInMsg = messaging.RWSpeedMsgReader()
        self.jointInMsgs = [messaging.HingedRigidBodyMsgReader() for _ in range(2)]
        self.wheelOutMsg = messaging.ArrayMotorTorqueMsg()
        self.errors: list[tuple[float, float]] = []
        """Times (s), and the angle to the planned attitude (rad)."""
        self._plan, self._known = plan, known

    def Reset(self, CurrentSimNanos: int) -> None:
        """Nothing is kept."""

    def UpdateState(self, CurrentSimNanos: int) -> None:
        """Torques of the wheels."""
        t, robot, state = CurrentSimNanos * 1e-9, self._known(), self.scStateInMsg()
        joints = [message() for message in self.jointInMsgs]
        q, qd = np.array([j.theta for j in joints]), [j.thetaDot for j in joints]
        w, now = np.array(state.omega_BN_B), inertia_at(robot, q)
        wheels = self.rwSpeedInMsg().wheelSpeeds[:3]
        h_rw = np.array([w.inertia for w in robot.wheels]) * wheels
        h = now.D @ w + now.D_q @ qd + h_rw

        # Modified Rodrigues parameters of N to B; ours is the turn of B in N.
        error = self._plan.attitude(t).inv() * Rotation.from_mrp(state.sigma_BN)
        e = error.as_rotvec()
        rate = error.inv().apply(self._plan.rate(t))
        taken = self._planned(robot, t + SHORT) - self._planned(robot, t)
        correction = BANDWIDTH**2 * e + 2 * DAMPING * BANDWIDTH * (w - rate)
        u = -taken / SHORT - np.cross(w, h) + now.D @ correction
        payload = messaging.ArrayMotorTorqueMsgPayload()
        payload.motorTorque = u.tolist()
        self.wheelOutMsg.write(payload, CurrentSimNanos, self.moduleID)
        self.errors.append((t, float(np.linalg.norm(e))))

    def _planned(self, robot: Robot, t: float) -> np.ndarray:
        """`h_rs` of the planned motion, N m s."""
        q, qd = self._plan.joints(t)
        planned = inertia_at(robot, q)
        return planned.D @ self._plan.rate(t) + planned.D_q @ qd
