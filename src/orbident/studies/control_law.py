"""Computed torques of joints and wheels together: base attitude and arm are tracked."""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from orbident.dynamics.control_laws import Now
from orbident.dynamics.equations_of_motion import Model, Speeds, equations_of_motion
from orbident.spatial.arrays import AnyArray
from orbident.spatial.rotations import cross, quaternion_matrix, rotate_back


class Slew(eqx.Module):
    """The base turns by an angle about an axis, from rest to rest, by a quintic."""

    start: Float[AnyArray, "4"]
    """Attitude at the start, unit quaternion, scalar last."""
    axis: Float[AnyArray, "3"]
    """Unit vector, base axes."""
    angle: float
    """rad."""
    duration: float
    """s."""

    def at(
        self, t: Float[AnyArray, ""]
    ) -> tuple[Float[AnyArray, "4"], Float[AnyArray, "3"], Float[AnyArray, "3"]]:
        """Attitude `x_WD`, rate and acceleration in D's axes, rad and s."""
        s = jnp.clip(t / self.duration, 0.0, 1.0)
        turned = self.angle * s**3 * (10 - 15 * s + 6 * s**2)
        rate = self.angle * 30 * s**2 * (1 - s) ** 2 / self.duration
        faster = self.angle * 60 * s * (1 - s) * (1 - 2 * s) / self.duration**2
        v, w = jnp.asarray(self.start[:3]), self.start[3]
        e, c = jnp.sin(turned / 2) * self.axis, jnp.cos(turned / 2)
        x_WD = jnp.append(w * e + c * v + cross(v, e), w * c - v @ e)
        return x_WD, rate * self.axis, faster * self.axis


class Tracking(eqx.Module):
    """The torques for which a model says `y'' = y_d'' + kd e' + kp e`, for all of y.

    `y` are the joints and the attitude of the base; the wheels' accelerations are what
    this takes, and the system CM is left alone.
    """

    model: Model
    of_momentum: Float[AnyArray, "wheels 3"]
    """The wheels' speeds for a momentum of theirs: the pseudo-inverse of `A_rw`."""
    slew: Slew
    kp: float
    """1/s^2."""
    kd: float
    """1/s."""

    def torques(
        self, now: Now
    ) -> tuple[Float[AnyArray, " joints"], Float[AnyArray, " wheels"]]:
        """Of the joints, N m or N, and on the rotors, N m."""
        v = now.speeds.stacked()
        at = equations_of_motion(self.model, now.q, v)
        w_dot, qdd = self._base(now), self._joints(now)
        # Eq. 10: no moment acts on the robot as a whole.
        known = Speeds(jnp.zeros(3), w_dot, qdd, jnp.zeros_like(now.speeds.qd_rw))
        left = (at.H @ known.stacked() + at.c)[3:6]
        vd = known._replace(qd_rw=-self.of_momentum @ left).stacked()
        Q = (at.H @ vd + at.c)[6:]
        return Q[: now.q.size], Q[now.q.size :]

    def _joints(self, now: Now) -> Float[AnyArray, " joints"]:
        e, e_d = now.command.q - now.q, now.command.qd - now.speeds.qd
        return now.command.qdd + self.kd * e_d + self.kp * e

    def _base(self, now: Now) -> Float[AnyArray, "3"]:
        x_WD, w_D, wd_D = self.slew.at(now.t)
        R_DB = quaternion_matrix(x_WD).T @ quaternion_matrix(now.x_WB)
        # R = 1 + [e]x to first order.
        skew = R_DB - R_DB.T
        e = jnp.array([skew[2, 1], skew[0, 2], skew[1, 0]]) / 2
        w, wanted = now.speeds.w, rotate_back(R_DB, w_D)
        slewing = rotate_back(R_DB, wd_D) - cross(w, wanted)
        return slewing + self.kd * (wanted - w) - self.kp * e


def tracking(model: Model, slew: Slew, kp: float, kd: float) -> Tracking:
    """The law by this model, for a robot whose wheels turn it about all axes."""
    return Tracking(model, np.linalg.pinv(model.wheels.A_rw), slew, kp, kd)


class OfJoints(eqx.Module):
    """The joints' part of it."""

    law: Tracking

    def __call__(self, now: Now) -> Float[AnyArray, " joints"]:
        """Torque of each joint, N m or N."""
        return self.law.torques(now)[0]


class OfWheels(eqx.Module):
    """The wheels' part of it."""

    law: Tracking

    def __call__(self, now: Now) -> Float[AnyArray, " wheels"]:
        """Torque on each rotor, N m."""
        return self.law.torques(now)[1]


def attitudes(slew: Slew, t: Float[np.ndarray, " n"]) -> Float[np.ndarray, "n 4"]:
    """The wanted attitudes at these times."""
    return np.array([slew.at(jnp.asarray(time))[0] for time in t])
