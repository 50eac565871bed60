"""What the motors of reaction wheels can do."""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Float

from orbident.spatial.arrays import AnyArray

TAPER = 0.02
"""Over this last part of its top speed a motor's torque falls to zero."""


class WheelLimits(NamedTuple):
    """The greatest torques and speeds; infinite where there is no limit."""

    torque: Float[AnyArray, " wheels"]
    """N m."""
    speed: Float[AnyArray, " wheels"]
    """Relative to the base, rad/s."""


def limited(
    limits: WheelLimits,
    tau_rw: Float[AnyArray, " wheels"],
    qd_rw: Float[AnyArray, " wheels"],
) -> Float[AnyArray, " wheels"]:
    """The torque that the motors give, of the torque that is asked for.

    At most the greatest torque, and none that drives a wheel beyond its top speed.

    Args:
        limits: of the motors.
        tau_rw: asked for, on the rotors, N m.
        qd_rw: speeds relative to the base, rad/s.
    """
    tau = jnp.clip(tau_rw, -limits.torque, limits.torque)
    left = 1 - jnp.sign(tau) * qd_rw / limits.speed
    return tau * jnp.clip(left / TAPER, 0.0, 1.0)
