"""What each sensor should show, and how that changes with the unknowns.

w = D^-1 (R_0^T h_cm - A_rw qd_rw - D_q qd)                       (Eqs. 2, 3)
v_S = v_cm - R_0 u,  u = w x r_cm + J_cm qd                       (Eqs. 27-30)
"""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Float

from orbident.dynamics.free_floating import Terms
from orbident.estimation.output_error.path import MIDDLE, NEXT, ROW, Changes, Path
from orbident.estimation.output_error.unknowns import Own
from orbident.spatial.arrays import AnyArray
from orbident.spatial.rotations import (
    cross,
    cross_matrix,
    product,
    rotate,
    rotate_back,
)


class Predicted(NamedTuple):
    """Of one sensor, at the rows."""

    value: Float[AnyArray, "rows axes"]
    slopes: Float[AnyArray, "rows axes unknowns"]


class Motion(NamedTuple):
    """A segment's motion at its nodes, and how it changes with the unknowns."""

    terms: Terms
    path: Path
    own: Own
    q: Float[AnyArray, "nodes joints"]
    t: Float[AnyArray, " nodes"]
    """Since time zero, s."""
    dt: Float[AnyArray, " rows"]
    rates: Terms
    """Of the terms."""
    h_rw_rate: Float[AnyArray, "nodes 3"]
    by_terms: Terms
    by_path: Changes
    by_own: Own
    by_q: Float[AnyArray, "nodes joints unknowns"]


def _gyro(at: Motion) -> Predicted:
    w = at.path.w[ROW] + at.own.gyro
    return Predicted(w, at.by_path.w[ROW] + at.by_own.gyro)


def _attitude(at: Motion) -> Predicted:
    """A quaternion; the slopes are those of its small rotation, base axes."""
    return Predicted(at.path.x_WB[ROW], at.by_path.phi[ROW])


def _joints(at: Motion) -> Predicted:
    return Predicted(at.q[ROW], at.by_q[ROW])


def _position(at: Motion) -> Predicted:
    R_WB, r_cm = at.path.R_WB[ROW], at.terms.r_cm[ROW]
    turned = product(cross_matrix(r_cm), at.by_path.phi[ROW])
    slopes = _cm_position(at.by_own, at.t[ROW, None, None])
    slopes -= product(R_WB, at.by_terms.r_cm[ROW] - turned)
    r_S = _cm_position(at.own, at.t[ROW, None]) - rotate(R_WB, r_cm)
    return Predicted(r_S, slopes)


def _cm_position(
    own: Own, t: Float[AnyArray, " rows *_"]
) -> Float[AnyArray, " rows *k"]:
    return own.r_cm + t * own.v_cm + t**2 / 2 * own.pull


def _cm_velocity(
    own: Own, t: Float[AnyArray, " rows *_"]
) -> Float[AnyArray, " rows *k"]:
    return own.v_cm + t * own.pull


def _u(at: Motion) -> Float[AnyArray, "nodes 3"]:
    return cross(at.path.w, at.terms.r_cm) + at.terms.v_q


def _velocity_slopes(at: Motion) -> Float[AnyArray, "nodes 3 unknowns"]:
    """Relative to the CM."""
    u = product(cross_matrix(at.path.w), at.by_terms.r_cm) + at.by_terms.v_q
    u -= product(cross_matrix(at.terms.r_cm), at.by_path.w)
    turned = product(cross_matrix(_u(at)), at.by_path.phi)
    return -product(at.path.R_WB, u - turned)


def _velocity(at: Motion) -> Predicted:
    t = at.t[ROW, None]
    v_S = _cm_velocity(at.own, t) - rotate(at.path.R_WB, _u(at))[ROW]
    slopes = _cm_velocity(at.by_own, t[..., None]) + _velocity_slopes(at)[ROW]
    return Predicted(v_S, slopes)


def _accelerometer(at: Motion) -> Predicted:
    """`f_S = -(u' + w x u)`; `w'` from `h_B' = R_0^T torque - w x h_B`.

    What pulls at all parts alike is not felt.
    """
    _, R_WB, E, h_B, w = (part[ROW] for part in at.path)
    r_cm, v_q = at.terms.r_cm[ROW], at.terms.v_q[ROW]
    D_dot, h_q_dot, _, v_q_dot = (part[ROW] for part in at.rates)
    h_dot = rotate_back(R_WB, at.own.torque[None]) - cross(w, h_B)
    w_dot = rotate(E, h_dot - rotate(D_dot, w) - h_q_dot - at.h_rw_rate[ROW])
    # The rate of r_cm, base axes, is v_q.
    u_dot = cross(w_dot, r_cm) + cross(w, v_q) + v_q_dot
    f_S = -(u_dot + cross(w, _u(at)[ROW]))
    # Of R_0^T dv_S/dt; the rate by the parabola through row, middle and next row.
    v = _velocity_slopes(at)
    dt = jnp.where(at.dt > 0, at.dt, jnp.inf)[:, None, None]
    v_dot = (4 * v[MIDDLE] - 3 * v[ROW] - v[NEXT]) / dt
    slopes = jnp.swapaxes(R_WB, 1, 2) @ v_dot
    slopes += product(cross_matrix(f_S), at.by_path.phi[ROW])
    return Predicted(f_S + at.own.accelerometer, slopes + at.by_own.accelerometer)


PREDICTIONS: Mapping[str, Callable[[Motion], Predicted]] = {
    "accelerometer": _accelerometer,
    "attitude": _attitude,
    "gyro": _gyro,
    "joints": _joints,
    "position": _position,
    "velocity": _velocity,
}
