"""Free floating along joint motions, so that it can be differentiated.

The same motion as `dynamics.free_floating`, made for a search: on one coarse grid, of
second order, and from the regressors alone. These are linear in the rates, so what a
base rate adds to them is found once, for every plausible robot:

    Y(q, qd, w) = Y(q, qd, 0) + sum_i w_i Y(q, 0, e_i),   h_rs = Y pi = D_q qd + D w
"""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from orbident.dynamics.attitude import RateLaw
from orbident.dynamics.wheels import Wheels, wheels_of
from orbident.regressors.minimal_sets import Regressors
from orbident.robot.description import Robot
from orbident.spatial.arrays import AnyArray
from orbident.spatial.rotations import quaternion_matrix, quaternion_rate
from orbident.trajectories.trajectory import InitialState


class Spacecraft(eqx.Module):
    """What floats, and how it starts; `h` are the axes in which momentum is kept."""

    regressors: Regressors
    wheels: Wheels
    x_WB: Float[AnyArray, "4"]
    """Attitude at the start."""
    w: Float[AnyArray, "3"]
    """Base rate at the start, base axes, rad/s."""
    qd_rw: Float[AnyArray, " wheels"]
    """Wheel speeds at the start, rad/s."""
    at_rest: bool = eqx.field(static=True)
    """All was at rest before the wheels spun up: `h_cm = 0` whatever the inertia."""


class Linear(NamedTuple):
    """A regressor over a motion: its part without a base rate, and by unit rates."""

    still: Float[AnyArray, "n rows m"]
    by_w: Float[AnyArray, "n h rows m"]

    def at(self, w: Float[AnyArray, "n h"]) -> Float[AnyArray, "n rows m"]:
        """The regressor at these base rates."""
        return self.still + jnp.einsum("nh,nhrm->nrm", w, self.by_w)


class Shown(NamedTuple):
    """What the joint motion alone shows."""

    Y: Linear
    W: Linear


class Floating(NamedTuple):
    """A motion at the nodes; base axes, of which those in `h` or `v`."""

    Y: Float[AnyArray, "n h pi"]
    W: Float[AnyArray, "n v phi"]
    w: Float[AnyArray, "n h"]
    """Base rate, rad/s."""
    R_h: Float[AnyArray, "n h h"]
    """`R_WB` of the axes in which angular momentum is kept."""
    R_v: Float[AnyArray, "n v v"]
    """The same of linear momentum."""
    half_turn: Float[AnyArray, " n"]
    """Cosine of half the angle from the first attitude."""
    qd_rw: Float[AnyArray, "n wheels"]
    """Relative to the base, rad/s."""
    E: Float[AnyArray, "n h h"]
    """`dw = E R_0^T dh_cm`."""
    lever: Float[AnyArray, "n v h"]
    """`dv_S = R_0 lever dw`, relative to the CM."""


def spacecraft_of(
    robot: Robot, regressors: Regressors, initial: InitialState, at_rest: bool
) -> Spacecraft:
    """The robot at the start of a manoeuvre."""
    return Spacecraft(
        regressors=regressors,
        wheels=wheels_of(robot),
        x_WB=initial.attitude,
        w=initial.angular_velocity,
        qd_rw=initial.wheel_speeds(robot.wheel_names),
        at_rest=at_rest,
    )


def shown_along(
    regressors: Regressors,
    q: Float[AnyArray, "n joints"],
    qd: Float[AnyArray, "n joints"],
) -> Shown:
    """The regressors of a joint motion, whatever the base does."""
    turning = np.array(regressors.momentum_axes)
    units = jnp.concatenate([jnp.zeros((1, 3)), jnp.eye(3)[turning]])

    def sample(q, qd):
        rates = jnp.zeros((len(units), qd.size)).at[0].set(qd)
        return jax.vmap(regressors, (None, 0, 0))(q, rates, units)

    Y, W = jax.vmap(sample)(q, qd)
    return Shown(Linear(Y[:, 0], Y[:, 1:]), Linear(W[:, 0], W[:, 1:]))


def float_along(
    craft: Spacecraft,
    shown: Shown,
    pi: Float[AnyArray, " pi"],
    phi: Float[AnyArray, " phi"],
    dt: float | Float[AnyArray, ""],
) -> Floating:
    """Eqs. 2, 17, 18: `w = D^-1 (R_0^T h_cm - A_rw qd_rw - D_q qd)`.

    Args:
        craft: what floats.
        shown: by its joint motion.
        pi: of one plausible robot.
        phi: of the same.
        dt: from node to node, s.
    """
    wheels, axes = craft.wheels, np.array(craft.regressors.momentum_axes)
    A, a = wheels.A_rw[axes], wheels.axes[axes]
    D_free = (A * wheels.free) @ a.T
    # A free wheel keeps its absolute spin: its momentum is A_rw (spin - a w).
    D = jnp.swapaxes(shown.Y.by_w @ pi, 1, 2)
    h_q = shown.Y.still @ pi
    E = jnp.linalg.inv(D - D_free)
    if craft.at_rest:
        # D w + h_q + h_rw = 0 at the start, whatever the robot makes of w.
        w = -jnp.linalg.solve(D[0], h_q[0] + A @ craft.qd_rw)
        h_B = jnp.zeros_like(w)
    else:
        w = craft.w[axes]
        h_B = D[0] @ w + h_q[0] + A @ craft.qd_rw
    spin = craft.qd_rw + wheels.free * (a.T @ w)
    b = jnp.einsum("nij,nj->ni", E, h_q + A @ spin)
    w, x_WB = _turn(craft, RateLaw(E, b), h_B, dt)
    return seen_along(craft, shown, (pi, phi), w, x_WB, spin - wheels.free * (w @ a))


def seen_along(
    craft: Spacecraft,
    shown: Shown,
    pi_phi: tuple[Float[AnyArray, " pi"], Float[AnyArray, " phi"]],
    w: Float[AnyArray, "n h"],
    x_WB: Float[AnyArray, "n 4"],
    qd_rw: Float[AnyArray, "n wheels"],
) -> Floating:
    """The motion of joints and base, however it was found."""
    wheels, axes = craft.wheels, np.array(craft.regressors.momentum_axes)
    D_free = (wheels.A_rw[axes] * wheels.free) @ wheels.axes[axes].T
    pi, phi = pi_phi
    R = quaternion_matrix(x_WB)
    moving = np.array(craft.regressors.velocity_axes)
    return Floating(
        Y=shown.Y.at(w),
        W=shown.W.at(w),
        w=w,
        R_h=R[:, axes][:, :, axes],
        R_v=R[:, moving][:, :, moving],
        half_turn=jnp.abs(x_WB @ craft.x_WB),
        qd_rw=qd_rw,
        E=jnp.linalg.inv(jnp.swapaxes(shown.Y.by_w @ pi, 1, 2) - D_free),
        lever=jnp.swapaxes(shown.W.by_w @ phi, 1, 2),
    )


def _turn(
    craft: Spacecraft,
    law: RateLaw,
    h_B: Float[AnyArray, " h"],
    dt: float | Float[AnyArray, ""],
) -> tuple[Float[AnyArray, "n h"], Float[AnyArray, "n 4"]]:
    """Base rate and attitude, from the momentum in base axes at the start."""
    x_WB = jnp.asarray(craft.x_WB)
    if h_B.size == 1:
        w = (law.E @ h_B) - law.b
        return w, _turned_about_z(x_WB, w[:, 0], dt)
    h_cm = quaternion_matrix(x_WB) @ h_B

    # Adams-Bashforth of order 2: one evaluation a step, and none between nodes.
    def step(state, here):
        x, earlier = state
        w = here.rate(x, h_cm)
        rate = quaternion_rate(x, w)
        later = x + dt * (1.5 * rate - 0.5 * earlier)
        return (later / jnp.linalg.norm(later), rate), (w, x)

    start = quaternion_rate(x_WB, RateLaw(law.E[0], law.b[0]).rate(x_WB, h_cm))
    return jax.lax.scan(step, (x_WB, start), law)[1]


def _turned_about_z(
    x_WB: Float[AnyArray, "4"],
    w: Float[AnyArray, " n"],
    dt: float | Float[AnyArray, ""],
) -> Float[AnyArray, "n 4"]:
    """In the plane the angle is an integral: by the trapezoidal rule."""
    half = jnp.concatenate([jnp.zeros(1), jnp.cumsum(dt / 2 * (w[1:] + w[:-1]))]) / 2
    sin, cos = jnp.sin(half), jnp.cos(half)
    none = jnp.zeros_like(half)
    z, s = x_WB[2], x_WB[3]
    return jnp.stack([none, none, z * cos + s * sin, s * cos - z * sin], axis=-1)
