"""The inertia-type matrices of Eqs. 3, 5 and 6, and the system CM.

All are linear in `theta` but for one division by the total mass, so a massless link
is nothing special.
"""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Float

from orbident.dynamics.kinematics import JointFields, joint_fields
from orbident.dynamics.tree import Poses, Tree, poses
from orbident.robot.parameters import FIRST_MOMENT, INERTIA, MASS
from orbident.spatial.arrays import AnyArray
from orbident.spatial.rotations import cross, cross_matrix, product, rotate


class Masses(eqx.Module):
    """Mass, first moment and inertia of some bodies about S, base axes."""

    m: Float[AnyArray, "*n"]
    s: Float[AnyArray, "*n 3"]
    J: Float[AnyArray, "*n 3 3"]


class Inertia(eqx.Module):
    """The inertia of the system at one configuration, base axes.

    `h_rs = D w + D_q qd` about the system CM (Eq. 3); kinetic energy about the CM
    `1/2 w D w + w D_q qd + 1/2 qd D_qq qd` (Eq. 6, wheels apart).
    """

    M: Float[AnyArray, ""]
    D: Float[AnyArray, "3 3"]
    D_q: Float[AnyArray, "3 joints"]
    D_qq: Float[AnyArray, "joints joints"]
    r_cm: Float[AnyArray, "3"]
    """From S to the system CM, m."""
    J_cm: Float[AnyArray, "3 joints"]
    """Velocity of the CM relative to S is `w x r_cm + J_cm qd`."""


def masses_about_S(at: Poses, theta: Float[AnyArray, "bodies 10"]) -> Masses:
    """Each body's `theta_i`, moved from its body frame to S and base axes."""
    m, d = theta[:, MASS], at.d
    s = rotate(at.R, theta[:, FIRST_MOMENT])
    xx, xy, yy, xz, yz, zz = jnp.moveaxis(theta[:, INERTIA], -1, 0)
    J = jnp.stack([xx, xy, xz, xy, yy, yz, xz, yz, zz], axis=-1).reshape(-1, 3, 3)
    J = product(product(at.R, J), jnp.swapaxes(at.R, -1, -2))
    # integral of -[d + r]x^2 dm over the body
    d_x, s_x = cross_matrix(d), cross_matrix(s)
    ds = product(d_x, s_x)
    shift = ds + jnp.swapaxes(ds, -1, -2) + m[:, None, None] * product(d_x, d_x)
    return Masses(m, s + m[:, None] * d, J - shift)


def inertia(
    tree: Tree, theta: Float[AnyArray, "bodies 10"], q: Float[AnyArray, " joints"]
) -> Inertia:
    """`M`, `D`, `D_q`, `D_qq` and the system CM at the configuration `q`."""
    at = poses(tree, q)
    bodies = masses_about_S(at, theta)
    M, s, J = bodies.m.sum(), bodies.s.sum(axis=0), bodies.J.sum(axis=0)
    fields = joint_fields(tree, at)
    p, h = _carried_momentum(tree, bodies, fields)

    # Koenig: about the CM, subtract what the whole mass at the CM would have.
    s_x = cross_matrix(s)
    D = J + product(s_x, s_x) / M
    D_q = h - cross(s[None], p) / M
    # Energy of joint k's field in the momentum of joint j, counted where j carries
    # no less than k: the composite of the deeper of the two.
    work = fields.w @ h.T + fields.u @ p.T
    below = tree.moves[:, 1:]
    upper = below * work
    D_qq = upper + upper.T - jnp.diag(jnp.diag(work)) - p @ p.T / M
    return Inertia(M, D, D_q.T, D_qq, s / M, p.T / M)


def _carried_momentum(
    tree: Tree, bodies: Masses, fields: JointFields
) -> tuple[Float[AnyArray, "joints 3"], Float[AnyArray, "joints 3"]]:
    """Linear and angular momentum about S of what each joint carries, at unit rate."""
    m = tree.moves @ bodies.m
    s = tree.moves @ bodies.s
    J = (tree.moves @ bodies.J.reshape(-1, 9)).reshape(-1, 3, 3)
    p = m[:, None] * fields.u + cross(fields.w, s)
    return p, cross(s, fields.u) + rotate(J, fields.w)
