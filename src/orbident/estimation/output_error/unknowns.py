"""The unknowns of one segment: its own, the joints' corrections, and `beta`."""

from typing import NamedTuple

from jaxtyping import Float

from orbident.spatial.arrays import AnyArray


class Own(NamedTuple):
    """Those that the inertia does not depend on; each is a vector."""

    turn: Float[AnyArray, "*n 3"]
    """Small rotation of the attitude at the segment's start, base axes, rad."""
    gyro: Float[AnyArray, "*n 3"]
    """Bias, rad/s."""
    accelerometer: Float[AnyArray, "*n 3"]
    """Bias, m/s^2."""
    h_cm: Float[AnyArray, "*n 3"]
    """At time zero, inertial axes, N m s."""
    v_cm: Float[AnyArray, "*n 3"]
    """At time zero, inertial axes, m/s."""
    r_cm: Float[AnyArray, "*n 3"]
    """At time zero, inertial axes, m."""
    torque: Float[AnyArray, "*n 3"]
    """From outside, inertial axes, N m."""
    pull: Float[AnyArray, "*n 3"]
    """Acceleration of the system CM, inertial axes, m/s^2."""


OWN = 3 * len(Own._fields)
LOCAL = 9
"""The first of them belong to one segment; the others to all."""
