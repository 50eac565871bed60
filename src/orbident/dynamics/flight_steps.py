"""Integration of a free-flying motion, by RK4 steps of given lengths."""

from collections.abc import Callable
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float

from orbident.compilation import compiled
from orbident.dynamics.control_laws import ControlLaw, JointCommand, Now
from orbident.dynamics.equations_of_motion import (
    Model,
    Speeds,
    equations_of_motion,
    split,
)
from orbident.dynamics.forward_inverse import accelerations
from orbident.dynamics.wheel_limits import WheelLimits, limited
from orbident.spatial.arrays import AnyArray
from orbident.spatial.rotations import (
    quaternion_matrix,
    quaternion_rate,
    rotate,
)

BATCH = 256
"""Steps integrated at once: few enough for short runs, one compiled size for all."""


class Vehicle(eqx.Module):
    """A robot and what drives it."""

    model: Model
    """The speed of a held wheel is not free."""
    joints: ControlLaw
    wheels: ControlLaw | None
    limits: WheelLimits


class Told(NamedTuple):
    """What drives a motion besides its own state."""

    t: Float[AnyArray, "*n"]
    command: JointCommand
    thrust: Float[AnyArray, "*n 6"]
    """Net force on the base and its moment about S, base axes."""


class Moving(NamedTuple):
    """What is integrated."""

    r_cm: Float[AnyArray, "*n 3"]
    """Position of the system CM, inertial axes, m."""
    x_WB: Float[AnyArray, "*n 4"]
    q: Float[AnyArray, "*n joints"]
    q_rw: Float[AnyArray, "*n wheels"]
    v: Float[AnyArray, "*n speeds"]
    """Generalised speeds, base axes."""


class Seen(NamedTuple):
    """What else there is to see in a state; base axes."""

    vd: Float[AnyArray, "*n speeds"]
    """The derivative of the generalised speeds."""
    v_S: Float[AnyArray, "*n 3"]
    f_S: Float[AnyArray, "*n 3"]
    """Acceleration of S."""
    p_S_cm: Float[AnyArray, "*n 3"]
    """From S to the system CM."""
    h: Float[AnyArray, "*n 3"]
    """Angular momentum about the system CM."""
    tau: Float[AnyArray, "*n joints"]
    tau_rw: Float[AnyArray, "*n wheels"]


def integrate(
    vehicle: Vehicle,
    start: Moving,
    nodes: Float[np.ndarray, "steps 3"],
    told_at: Callable[[Float[np.ndarray, "rows 3"]], Told],
    wanted: Bool[np.ndarray, " steps"],
) -> tuple[Moving, Seen, Told]:
    """The states at the start of the wanted steps, and what is seen and told there.

    Args:
        vehicle: what moves.
        start: the first state.
        nodes: start, middle and end of each step, s. The last step may have no length,
            and shows the end.
        told_at: what the vehicle is told at the nodes of some steps, `[rows, 3]`.
        wanted: the steps to show.
    """
    steps = len(nodes)
    x, pieces = start, []
    for first in range(0, steps, BATCH):
        chosen = np.arange(first, first + BATCH)
        rows = np.minimum(chosen, steps - 1)
        # Steps of zero length fill up the last batch.
        h = np.where(chosen < steps, nodes[rows, 2] - nodes[rows, 0], 0.0)
        told = told_at(nodes[rows])
        x, path = _scan(vehicle, x, h, told)
        show = (chosen < steps) & wanted[rows]
        path = (*path, jax.tree.map(lambda a: a[:, 0], told))
        pieces.append(jax.tree.map(lambda a, k=show: np.asarray(a)[k], path))
    return jax.tree.map(lambda *parts: np.concatenate(parts), *pieces)


@compiled
def _scan(
    vehicle: Vehicle, start: Moving, h: Float[AnyArray, " steps"], told: Told
) -> tuple[Moving, tuple[Moving, Seen]]:
    # A loop over RK4's four stages: their one body is compiled once.
    along, weight = jnp.array([0, 0.5, 0.5, 1]), jnp.array([1, 2, 2, 1]) / 6
    node = jnp.array([0, 1, 1, 2])

    def step(
        x: Moving, each: tuple[Float[AnyArray, ""], Told]
    ) -> tuple[Moving, tuple[Moving, Seen]]:
        h, told = each

        def stage(
            carry: tuple[Moving, Moving],
            each: tuple[Float[AnyArray, ""], Float[AnyArray, ""], Told],
        ) -> tuple[tuple[Moving, Moving], Seen]:
            total, slope = carry
            along, weight, told = each
            slope, seen = _rate(vehicle, _moved(x, along * h, slope), told)
            return (_moved(total, weight * h, slope), slope), seen

        stages = (along, weight, jax.tree.map(lambda a: a[node], told))
        (end, _), seen = jax.lax.scan(stage, (x, x), stages)
        end = end._replace(x_WB=end.x_WB / jnp.linalg.norm(end.x_WB))
        return end, (x, jax.tree.map(lambda a: a[0], seen))

    return jax.lax.scan(step, start, (h, told))


def _moved(x: Moving, h: Float[AnyArray, ""], slope: Moving) -> Moving:
    return jax.tree.map(lambda a, b: a + h * b, x, slope)


def _rate(vehicle: Vehicle, x: Moving, told: Told) -> tuple[Moving, Seen]:
    """The derivative of the state under the laws and the thrusters (Eqs. 13, 15)."""
    model, speeds = vehicle.model, split(vehicle.model, x.v)
    now = Now(told.t, x.q, x.x_WB, speeds, told.command)
    tau = jnp.asarray(vehicle.joints(now))
    tau_rw = jnp.zeros_like(speeds.qd_rw)
    if vehicle.wheels is not None:
        tau_rw = limited(vehicle.limits, vehicle.wheels(now), speeds.qd_rw)
    at = equations_of_motion(model, x.q, x.v)
    driven = Speeds(jnp.zeros(3), jnp.zeros(3), tau, tau_rw)
    Q = driven.stacked() + at.J_S.T @ told.thrust
    vd = accelerations(at, Q, jnp.zeros_like(x.v), model.free)
    slope = Moving(
        r_cm=rotate(quaternion_matrix(x.x_WB), speeds.v_cm),
        x_WB=quaternion_rate(x.x_WB, speeds.w),
        q=speeds.qd,
        q_rw=speeds.qd_rw,
        v=vd,
    )
    seen = Seen(
        vd=vd,
        v_S=at.J_S[:3] @ x.v,
        f_S=at.J_S[:3] @ vd + at.f_S,
        p_S_cm=at.r_cm,
        h=at.H[3:6] @ x.v,
        tau=tau,
        # Eq. 12; of a held wheel, the torque that holds it.
        tau_rw=split(model, at.H @ vd).qd_rw,
    )
    return slope, seen
