"""Control laws of joints and wheels, as pure functions of what is happening."""

from typing import NamedTuple, Protocol, runtime_checkable

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from orbident.dynamics.equations_of_motion import (
    Model,
    Speeds,
    equations_of_motion,
)
from orbident.dynamics.forward_inverse import accelerations
from orbident.robot.description import Robot
from orbident.spatial.arrays import AnyArray
from orbident.spatial.rotations import cross


class JointCommand(NamedTuple):
    """What the joints are told to do now; rad or m, and s."""

    q: Float[AnyArray, " joints"]
    qd: Float[AnyArray, " joints"]
    qdd: Float[AnyArray, " joints"]


class Now(NamedTuple):
    """What a control law is told."""

    t: Float[AnyArray, ""]
    q: Float[AnyArray, " joints"]
    x_WB: Float[AnyArray, "4"]
    speeds: Speeds
    command: JointCommand


@runtime_checkable
class ControlLaw(Protocol):
    """A pure JAX function, itself a tree of arrays: its gains."""

    def __call__(self, now: Now) -> Float[AnyArray, " actuators"]:
        """Torques: of each joint (N m or N), or of each wheel on its rotor (N m)."""
        ...


class Hold(NamedTuple):
    """Joints that are told to stay."""

    q: Float[np.ndarray, " joints"]

    def at(
        self, t: Float[np.ndarray, " n"]
    ) -> tuple[
        Float[np.ndarray, "n joints"],
        Float[np.ndarray, "n joints"],
        Float[np.ndarray, "n joints"],
    ]:
        """The same positions at all times, without rates and accelerations."""
        q = np.tile(self.q, (t.size, 1))
        return q, np.zeros_like(q), np.zeros_like(q)


class JointPD(eqx.Module):
    """`tau = Kp (q_d - q) + Kd (qd_d - qd)`."""

    Kp: Float[AnyArray, " joints"]
    Kd: Float[AnyArray, " joints"]

    def __call__(self, now: Now) -> Float[AnyArray, " joints"]:
        """Torque of each joint, N m or N."""
        e, e_d = now.command.q - now.q, now.command.qd - now.speeds.qd
        return self.Kp * e + self.Kd * e_d


class ComputedTorque(eqx.Module):
    """The torques for which a model says `qdd = qdd_d + kd (qd_d - qd) + kp (q_d - q)`.

    The base floats, and the wheels turn without torque.
    """

    model: Model
    kp: Float[AnyArray, " joints"]
    """1/s^2."""
    kd: Float[AnyArray, " joints"]
    """1/s."""

    def __call__(self, now: Now) -> Float[AnyArray, " joints"]:
        """Torque of each joint, N m or N."""
        e, e_d = now.command.q - now.q, now.command.qd - now.speeds.qd
        wanted = now.command.qdd + self.kd * e_d + self.kp * e
        v = now.speeds.stacked()
        joints = slice(6, 6 + now.q.size)
        at = equations_of_motion(self.model, now.q, v)
        vd = accelerations(
            at,
            jnp.zeros_like(v),
            jnp.zeros_like(v).at[joints].set(wanted),
            jnp.asarray(self.model.free).at[joints].set(0.0),
        )
        return (at.H @ vd + at.c)[joints]


class WheelSpeed(eqx.Module):
    """`tau_rw = k (qd_rw,d - qd_rw)`: brings each wheel to a speed."""

    k: Float[AnyArray, " wheels"]
    """N m s/rad."""
    speed: Float[AnyArray, " wheels"]
    """Relative to the base, rad/s."""

    def __call__(self, now: Now) -> Float[AnyArray, " wheels"]:
        """Torque on each rotor, N m."""
        return self.k * (self.speed - now.speeds.qd_rw)


class AttitudeHold(eqx.Module):
    """The wheels turn the base back to an attitude: `n = -kp e - kd w`.

    `e` is twice the vector part of the quaternion from the wanted attitude, base
    axes; a rotor that is driven by `tau_rw` turns the base by `-a tau_rw`.
    """

    kp: Float[AnyArray, ""]
    """N m/rad."""
    kd: Float[AnyArray, ""]
    """N m s/rad."""
    x_WD: Float[AnyArray, "4"]
    """The attitude to hold, unit quaternion, scalar last."""
    share: Float[AnyArray, "wheels 3"]
    """The wheels' part in a moment on the base: the pseudo-inverse of their axes."""

    def __call__(self, now: Now) -> Float[AnyArray, " wheels"]:
        """Torque on each rotor, N m."""
        # conj(x_WD) x_WB, the shorter way round.
        d, b = jnp.asarray(self.x_WD), now.x_WB
        vector = d[3] * b[:3] - b[3] * d[:3] - cross(d[:3], b[:3])
        e = 2 * vector * jnp.where(d @ b < 0, -1.0, 1.0)
        return self.share @ (self.kp * e + self.kd * now.speeds.w)


def attitude_hold(
    robot: Robot, kp: float, kd: float, attitude: Float[np.ndarray, "4"]
) -> AttitudeHold:
    """The law for a robot's wheels, about the axes that they span.

    Args:
        robot: with wheels.
        kp: N m/rad.
        kd: N m s/rad.
        attitude: to hold, unit quaternion, scalar last.
    """
    axes = np.reshape([wheel.axis for wheel in robot.wheels], (-1, 3)).T
    return AttitudeHold(np.array(kp), np.array(kd), attitude, np.linalg.pinv(axes))
