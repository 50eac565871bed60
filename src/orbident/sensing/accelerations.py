"""How the base of a free-floating robot accelerates, from conserved momentum."""

from functools import partial
from typing import NamedTuple

import jax
import numpy as np
from jaxtyping import Float

from orbident.compilation import compiled
from orbident.dynamics.attitude import rate_law
from orbident.dynamics.batches import in_batches
from orbident.dynamics.free_floating import FreeFloating, Terms
from orbident.dynamics.inertia import inertia
from orbident.dynamics.tree import Tree, tree_of
from orbident.dynamics.wheels import wheels_of
from orbident.precision import in_float64
from orbident.robot.description import Robot
from orbident.spatial.arrays import AnyArray


class Accelerations(NamedTuple):
    """Accelerations of the base and the wheels at the samples of a motion."""

    w_dot: Float[np.ndarray, "n 3"]
    """Of the base rate, base axes, rad/s^2."""
    qdd_rw: Float[np.ndarray, "n wheels"]
    """Of the wheels relative to the base, rad/s^2."""
    f_S: Float[np.ndarray, "n 3"]
    """Specific force at S, `R_0^T dv_S/dt`, base axes, m/s^2: no gravity is felt."""


@in_float64
def accelerations(
    robot: Robot, motion: FreeFloating, qdd: Float[np.ndarray, "n joints"]
) -> Accelerations:
    """Differentiate the two momentum laws in time, exactly.

    Of Eqs. 2 and 3, `D w + D_q qd + A_rw qd_rw = R_0^T h_cm`:

        D w_dot + A_rw qdd_rw = -w x (R_0^T h_cm) - D' w - (D_q qd)'

    with `qdd_rw = 0` of a held wheel and `-a.w_dot` of a free one; of Eqs. 27-30,
    `R_0^T (v_S - v_cm) = -u` with `u = w x r_cm + J_cm qd`:

        f_S = -(u' + w x u)

    Args:
        robot: with its nominal inertia.
        motion: the free-floating motion.
        qdd: joint accelerations at its samples, rad/s^2 or m/s^2.
    """
    wheels = wheels_of(robot)
    at, rate = in_batches(
        partial(_terms_and_rates, tree_of(robot), robot.theta),
        motion.q,
        motion.qd,
        qdd,
    )
    w = motion.w
    h_B = _times(at.D, w) + at.h_q + motion.qd_rw @ wheels.A_rw.T
    torque = -np.cross(w, h_B) - _times(rate.D, w) - rate.h_q
    D_free = (wheels.A_rw * wheels.free) @ wheels.axes.T
    E = rate_law(at.D - D_free, h_B, robot.motion == "planar").E
    w_dot = _times(np.asarray(E), torque)

    u = np.cross(w, at.r_cm) + at.v_q
    u_dot = np.cross(w_dot, at.r_cm) + np.cross(w, at.v_q) + rate.v_q
    return Accelerations(
        w_dot=w_dot,
        qdd_rw=-np.asarray(wheels.free) * (w_dot @ wheels.axes),
        f_S=-(u_dot + np.cross(w, u)),
    )


@compiled
def _terms_and_rates(
    tree: Tree,
    theta: Float[AnyArray, "bodies 10"],
    q: Float[AnyArray, "n joints"],
    qd: Float[AnyArray, "n joints"],
    qdd: Float[AnyArray, "n joints"],
) -> tuple[Terms, Terms]:
    """What momentum needs of the joint states, and its time derivative."""

    def terms(q: Float[AnyArray, " joints"], qd: Float[AnyArray, " joints"]) -> Terms:
        at = inertia(tree, theta, q)
        return Terms(at.D, at.D_q @ qd, at.r_cm, at.J_cm @ qd)

    return jax.vmap(lambda q, qd, qdd: jax.jvp(terms, (q, qd), (qd, qdd)))(q, qd, qdd)


def _times(
    A: Float[np.ndarray, "n 3 3"], v: Float[np.ndarray, "n 3"]
) -> Float[np.ndarray, "n 3"]:
    return np.einsum("nij,nj->ni", A, v)
