"""A module for Basilisk that estimates mass properties while the simulation runs.

It reads a spacecraft's state, its wheel speeds and the joints of its spinning bodies,
and hands them to the filter that `orbident live` runs.
"""

from dataclasses import replace

import numpy as np
from Basilisk.architecture import messaging, sysModel
from scipy.spatial.transform import Rotation

from orbident.live.live_filter import LiveEvent, LiveFilter
from orbident.live.session import nothing_carried
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import Robot

SURE = 0.01
"""Part of the mass: with a larger deviation an estimate is not used."""


class MassProperties(sysModel.SysModel):
    """Estimates the base parameters of a robot, and reports changes.

    Subscribe `scStateInMsg`, `rwSpeedInMsg` and every one of `jointInMsgs`, in the
    robot's order. The point S of the robot file has to be the hub's point B.
    """

    def __init__(
        self, robot: Robot, gyro_std: float, velocity_std: float, every: float = 1.0
    ) -> None:
        """Estimate from CAD values, 30 % uncertain.

        Args:
            robot: with the noise of its gyro.
            gyro_std: of the noise that is added to a rate, rad/s.
            velocity_std: of the noise that is added to a velocity, m/s.
            every: time between two estimates, s.
        """
        super().__init__()
        self.ModelTag = "massProperties"
        self.scStateInMsg = messaging.SCStatesMsgReader()
        self.rwSpeedInMsg = messaging.RWSpeedMsgReader()
        self.jointInMsgs = [messaging.HingedRigidBodyMsgReader() for _ in robot.joints]
        self.events: list[LiveEvent] = []
        """All estimates and changes so far."""
        self.identified = robot
        """The robot that moves as the latest estimate says that is sure enough."""
        self._filter = LiveFilter(robot, velocity_std, every, nothing_carried(robot))
        self._stds = gyro_std, velocity_std
        self._robot, self._wheels = robot, len(robot.wheels)
        self._random = np.random.default_rng(0)

    def Reset(self, CurrentSimNanos: int) -> None:
        """Basilisk calls this once, before the first step."""

    def UpdateState(self, CurrentSimNanos: int) -> None:
        """Take one sample in."""
        state = self.scStateInMsg()
        joints = [message() for message in self.jointInMsgs]
        # Modified Rodrigues parameters of N to B; ours is the turn of B in N.
        x_WB = Rotation.from_mrp(state.sigma_BN).as_quat()
        w, v = (
            np.array(exact) + std * self._random.standard_normal(3)
            for exact, std in zip(
                (state.omega_BN_B, state.v_BN_N), self._stds, strict=True
            )
        )
        q, qd = [j.theta for j in joints], [j.thetaDot for j in joints]
        qd_rw = self.rwSpeedInMsg().wheelSpeeds[: self._wheels]
        t = [CurrentSimNanos * 1e-9]
        row = np.concatenate([t, q, qd, w, x_WB, qd_rw, v, w])
        told = self._filter.take(row[None])
        self.events += told
        for event in told:
            if event.kind == "estimate" and _sure(event):
                self.identified = self._with(event.of["beta"])

    def _with(self, beta: list[float]) -> Robot:
        """One of all robots that have these base parameters."""
        theta = minimal_sets(self._robot).base.theta_of @ beta
        return replace(self._robot, theta=theta.reshape(self._robot.theta.shape))


def _sure(estimate: LiveEvent) -> bool:
    return estimate.of["std"][0] < SURE * estimate.of["beta"][0]
