"""What a robot is commanded to do, as data that the core evaluates."""

from collections.abc import Callable
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float

from orbident.model.kinematics import JointState
from orbident.robot.description import Robot


class Hold(NamedTuple):
    """Joints that are commanded to stay."""

    q: Float[np.ndarray, " joints"]

    def at(self, t: Float[np.ndarray, " n"]) -> JointState:
        """Positions, rates and accelerations at the times `t`, s: all joints rest."""
        q = np.tile(self.q, (t.size, 1))
        return q, np.zeros_like(q), np.zeros_like(q)


class JointPD(NamedTuple):
    """`tau = Kp (q_d - q) + Kd (qd_d - qd)`, N m or N."""

    Kp: Float[np.ndarray, " joints"]
    Kd: Float[np.ndarray, " joints"]


class Driven(NamedTuple):
    """The joints do exactly as commanded, whatever torque that takes."""


class WheelSpeed(NamedTuple):
    """`tau_rw = k (qd_rw,d - qd_rw)`: brings each wheel to a speed."""

    k: Float[np.ndarray, " wheels"]
    """N m s/rad."""
    speed: Float[np.ndarray, " wheels"]
    """Relative to the base, rad/s."""


class AttitudeHold(NamedTuple):
    """The wheels turn the base back to an attitude: `n = -kp e - kd w`.

    `e` is twice the vector part of the quaternion from the wanted attitude, base
    axes; a rotor that is driven by `tau_rw` turns the base by `-a tau_rw`.
    """

    kp: float
    """N m/rad."""
    kd: float
    """N m s/rad."""
    x_WD: Float[np.ndarray, "4"]
    """The attitude to hold, unit quaternion, scalar last."""
    share: Float[np.ndarray, "wheels 3"]
    """The wheels' part in a moment on the base: the pseudo-inverse of their axes."""


class OpenLoop(NamedTuple):
    """Torques that depend on time alone."""

    torque: Callable[[Float[np.ndarray, " n"]], Float[np.ndarray, "n actuators"]]
    """Torque at given times (s): of each joint (N m or N), or on each rotor (N m)."""


AttitudeState = tuple[
    Float[np.ndarray, "n 4"], Float[np.ndarray, "n 3"], Float[np.ndarray, "n 3"]
]
"""Attitude `x_WD`; its rate and acceleration in D's axes, rad and s."""


@runtime_checkable
class AttitudeMotion(Protocol):
    """What the base is commanded to do: any function of time."""

    def at(self, t: Float[np.ndarray, " n"]) -> AttitudeState:
        """The attitude at the times `t`, s, and how it changes."""
        ...


class ComputedTorque(NamedTuple):
    """The torques for which a model says `y'' = y_d'' + kd e' + kp e`, for all of y.

    `y` are the joints and the attitude of the base; the wheels' accelerations are what
    this takes, and the system CM is left alone. One such law is the law of the joints
    and of the wheels.
    """

    model: Robot
    """The robot as the controller has it: torques follow from its `theta`."""
    base: AttitudeMotion
    kp: float
    """1/s^2."""
    kd: float
    """1/s."""


JointLaw = JointPD | Driven | OpenLoop | ComputedTorque


WheelLaw = WheelSpeed | AttitudeHold | OpenLoop | ComputedTorque


class WheelLimits(NamedTuple):
    """The greatest torques and speeds of motors; infinite where there is no limit.

    A motor gives at most its greatest torque, and none that drives the wheel beyond its
    top speed: over the last 2 % of that speed the torque falls to zero.
    """

    torque: Float[np.ndarray, " wheels"]
    """N m."""
    speed: Float[np.ndarray, " wheels"]
    """Relative to the base, rad/s."""


def attitude_hold(
    robot: Robot, kp: float, kd: float, attitude: Float[np.ndarray, "4"]
) -> AttitudeHold:
    """The law for a robot's wheels, about the axes that they span.

    `kp` is in N m/rad and `kd` in N m s/rad; the attitude is a unit quaternion, scalar
    last.
    """
    axes = np.reshape([wheel.axis for wheel in robot.wheels], (-1, 3)).T
    return AttitudeHold(kp, kd, attitude, np.linalg.pinv(axes))
