"""The free-flying equations of motion, `H+ v' + c+ = Q` (Eqs. 8-14).

Generalised speeds `v = [v_cm, w, qd, qd_rw]`: the velocity of the system CM, the base
rate, the joint rates, and the wheels' speeds relative to the base; `v_cm` and `w` are
inertial motions in base axes, and `v'` is the derivative of these components.
"""

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from orbident.dynamics.inertia import Inertia, inertia, masses_about_S
from orbident.dynamics.kinematics import joint_fields
from orbident.dynamics.tree import Tree, poses, tree_of
from orbident.dynamics.wheels import Wheels, wheels_of
from orbident.robot.description import Robot
from orbident.spatial.arrays import AnyArray
from orbident.spatial.rotations import cross, cross_matrix, rotate

OUT_OF_PLANE = [2, 3, 4]
"""Of the speeds: along z, about x and about y."""


class Model(eqx.Module):
    """What the equations of motion need of a robot."""

    tree: Tree
    theta: Float[AnyArray, "bodies 10"]
    wheels: Wheels
    free: Float[AnyArray, " speeds"]
    """1 where a speed may change; 0 out of the plane of a planar robot."""


class Speeds(NamedTuple):
    """The parts of `v`, or of `v'`, `c+` and `Q`."""

    v_cm: Float[AnyArray, "3"]
    w: Float[AnyArray, "3"]
    qd: Float[AnyArray, " joints"]
    qd_rw: Float[AnyArray, " wheels"]

    def stacked(self) -> Float[AnyArray, " speeds"]:
        """`[v_cm, w, qd, qd_rw]`."""
        return jnp.concatenate(self)


class Equations(NamedTuple):
    """The equations of motion in one state, and how S moves; base axes."""

    H: Float[AnyArray, "speeds speeds"]
    """`H+` of Eq. 14."""
    c: Float[AnyArray, " speeds"]
    """`c+` of Eq. 13."""
    J_S: Float[AnyArray, "6 speeds"]
    """Velocity of S and base rate are `J_S v` (Eq. 27)."""
    f_S: Float[AnyArray, "3"]
    """The acceleration of S is `J_S v' + f_S`, m/s^2."""
    r_cm: Float[AnyArray, "3"]
    """From S to the system CM, m."""


def model_of(robot: Robot) -> Model:
    """The robot's model, with its nominal inertia."""
    free = np.ones(6 + len(robot.joints) + len(robot.wheels))
    if robot.motion == "planar":
        free[OUT_OF_PLANE] = 0.0
    return Model(tree_of(robot), robot.theta, wheels_of(robot), free)


def split(model: Model, v: Float[AnyArray, " speeds"]) -> Speeds:
    """`v` taken apart."""
    joints_end = 6 + model.tree.parent.shape[0]
    return Speeds(v[:3], v[3:6], v[6:joints_end], v[joints_end:])


def H_plus(
    model: Model, q: Float[AnyArray, " joints"]
) -> Float[AnyArray, "speeds speeds"]:
    """The system inertia matrix `H+` (Eq. 14).

    Args:
        model: the robot's.
        q: joint positions, rad or m.

    Returns:
        Over `[v_cm, w, qd, qd_rw]`, base axes; symmetric.

    Raises:
        InputError: `q` is not float64.
    """
    return _H_plus(model, inertia(model.tree, model.theta, q))


def c_plus(
    model: Model,
    q: Float[AnyArray, " joints"],
    v: Float[AnyArray, " speeds"],
) -> Float[AnyArray, " speeds"]:
    """The velocity-dependent forces `c+` (Eqs. 9-13): `Q` where `v' = 0`.

    Args:
        model: the robot's.
        q: joint positions, rad or m.
        v: generalised speeds, base axes.

    Raises:
        InputError: `q` is not float64.
    """
    return _bias(model, q, split(model, v))[0]


def equations_of_motion(
    model: Model,
    q: Float[AnyArray, " joints"],
    v: Float[AnyArray, " speeds"],
) -> Equations:
    """`H+`, `c+` and the motion of S in one state.

    Args:
        model: the robot's.
        q: joint positions, rad or m.
        v: generalised speeds, base axes.

    Raises:
        InputError: `q` is not float64.
    """
    at = inertia(model.tree, model.theta, q)
    c, f_S = _bias(model, q, split(model, v))
    return Equations(_H_plus(model, at), c, velocity_of_S(model, at), f_S, at.r_cm)


def velocity_of_S(model: Model, at: Inertia) -> Float[AnyArray, "6 speeds"]:
    """`J_0,S` (Eqs. 27, 28): `v_S = v_cm - w x r_cm - J_cm qd`."""
    eye, zero = jnp.eye(3), jnp.zeros((3, 3))
    wheels = jnp.zeros((3, model.wheels.free.shape[0]))
    linear = [eye, cross_matrix(at.r_cm), -at.J_cm, wheels]
    angular = [zero, eye, jnp.zeros_like(at.J_cm), wheels]
    return jnp.block([linear, angular])


def _H_plus(model: Model, at: Inertia) -> Float[AnyArray, "speeds speeds"]:
    A_rw = model.wheels.A_rw
    joints, wheels = at.D_q.shape[1], A_rw.shape[1]
    I_rw = jnp.diag(jnp.sum(model.wheels.axes * A_rw, axis=0))
    at_cm = jnp.zeros((3, 3 + joints + wheels))
    free = jnp.zeros((joints, wheels))
    return jnp.block(
        [
            [at.M * jnp.eye(3), at_cm],
            [
                at_cm.T,
                jnp.block(
                    [
                        [at.D, at.D_q, A_rw],
                        [at.D_q.T, at.D_qq, free],
                        [A_rw.T, free.T, I_rw],
                    ]
                ),
            ],
        ]
    )


def _bias(
    model: Model, q: Float[AnyArray, " joints"], v: Speeds
) -> tuple[Float[AnyArray, " speeds"], Float[AnyArray, "3"]]:
    """`c+` and the acceleration of S at `v' = 0`, by Newton and Euler.

    A rigid motion is the pair (w, u) of its rate and its velocity at S, now; forces
    and momenta are taken about that point. The system CM is at rest: its own motion
    adds to nothing but the force, `M w x v_cm`.
    """
    tree, w, qd = model.tree, v.w, v.qd[:, None]
    at = poses(tree, q)
    fields = joint_fields(tree, at)
    bodies = masses_about_S(at, model.theta)
    m, s, J = bodies.m[:, None], bodies.s, bodies.J
    M = bodies.m.sum()

    # V_i = V_0 + sum of what the joints that move it add, S_k qd_k.
    w_i = w + tree.moves.T @ (fields.w * qd)
    u_i = tree.moves.T @ (fields.u * qd)
    u_i -= (m * u_i + cross(w_i, s)).sum(axis=0) / M
    p = m * u_i + cross(w_i, s)
    l = cross(s, u_i) + rotate(J, w_i)
    l += jnp.zeros_like(l).at[0].set(model.wheels.A_rw @ v.qd_rw)

    # S_k is fixed in the body that the joint moves: S_k' = V_k x S_k.
    w_k, u_k = w_i[1:], u_i[1:]
    S_w = cross(w_k, fields.w)
    S_u = cross(w_k, fields.u) + cross(u_k, fields.w)
    a_w = tree.moves.T @ (S_w * qd)
    a_u = tree.moves.T @ (S_u * qd)

    # The rate of each body's momentum; S accelerates so that in all there is no force.
    f = m * a_u + cross(a_w, s) + cross(w_i, p)
    a_0 = -f.sum(axis=0) / M
    f += m * a_0
    n = cross(s, a_u + a_0) + rotate(J, a_w) + cross(w_i, l) + cross(u_i, p)

    # A joint's torque is the power of what it carries, at unit rate.
    tau = fields.w * (tree.moves @ n) + fields.u * (tree.moves @ f)
    c = Speeds(M * cross(w, v.v_cm), n.sum(axis=0), tau.sum(axis=1), 0 * v.qd_rw)
    return c.stacked(), a_0 + cross(w, v.v_cm) + cross(w, u_i[0])
