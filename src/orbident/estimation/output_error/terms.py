"""What momentum and velocity need of the joints, and its derivatives."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Float

from orbident.dynamics.free_floating import Terms
from orbident.dynamics.inertia import Inertia, inertia
from orbident.dynamics.tree import Tree
from orbident.regressors.momentum import momentum
from orbident.spatial.arrays import AnyArray
from orbident.spatial.rotations import cross, cross_matrix


class Body(NamedTuple):
    """The robot as far as it is known beforehand."""

    tree: Tree
    theta_of: Float[AnyArray, "theta beta"]
    """A `theta` with the momentum of any `beta`; it need not be physical."""


class JointState(NamedTuple):
    """Of one instant, or of several."""

    q: Float[AnyArray, "*n joints"]
    qd: Float[AnyArray, "*n joints"]
    qdd: Float[AnyArray, "*n joints"]


class Expansion(NamedTuple):
    """The terms at one instant, and how they change."""

    terms: Terms
    rates: Terms
    """In time."""
    by: Terms
    """Derivatives, last axis: by the joints' corrections, then by `beta`."""


def expanded(
    body: Body,
    beta: Float[AnyArray, " beta"],
    joints: JointState,
    basis: Float[AnyArray, "3 functions"],
) -> Expansion:
    """`D`, `D_q qd` (Eq. 3), `r_cm` and `J_cm qd` (Eq. 30), with their derivatives.

    A correction of a joint is a sum of `functions`, whose values and rates are the
    first two rows of `basis`.
    """
    theta = (body.theta_of @ beta).reshape(-1, 10)
    q, qd, qdd = joints

    def terms(q: Float[AnyArray, " joints"]) -> tuple[Terms, tuple[Terms, Inertia]]:
        at = inertia(body.tree, theta, q)
        found = Terms(at.D, at.D_q @ qd, at.r_cm, at.J_cm @ qd)
        return found, (found, at)

    by_q, (found, at) = jax.jacfwd(terms, has_aux=True)(q)
    by_qd = Terms(jnp.zeros((3, 3, q.size)), at.D_q, jnp.zeros((3, q.size)), at.J_cm)

    def columns(beta, q, qd):
        by = q[..., None, :] * basis[0][:, None] + qd[..., None, :] * basis[1][:, None]
        by = by.reshape(*by.shape[:-2], by.shape[-2] * by.shape[-1])
        return jnp.concatenate([by, beta], axis=-1)

    return Expansion(
        terms=found,
        rates=jax.tree.map(lambda by_q, by_qd: by_q @ qd + by_qd @ qdd, by_q, by_qd),
        by=jax.tree.map(columns, _by_beta(body, beta, q, qd), by_q, by_qd),
    )


def _by_beta(
    body: Body,
    beta: Float[AnyArray, " beta"],
    q: Float[AnyArray, " joints"],
    qd: Float[AnyArray, " joints"],
) -> Terms:
    """From the momentum at unit base rates, and with the joints moving alone.

    Those are linear in `beta`; about the system CM they are not (Koenig).
    """
    rates = jnp.concatenate([jnp.eye(3), jnp.zeros((1, 3))])
    moving = jnp.zeros((4, q.size)).at[3].set(qd)
    at = jax.vmap(lambda qd, w: momentum(body.tree, q, qd, w))(moving, rates)
    parts = *at.A, at.S[0], at.P[3]
    X = jnp.concatenate(parts) @ body.theta_of

    def about_cm(x: Float[AnyArray, "18"], M: Float[AnyArray, ""]) -> Terms:
        *D_S, h_S, s, p = jnp.split(x, 6)
        s_x = cross_matrix(s)
        D = jnp.stack(D_S, axis=1) + s_x @ s_x / M
        return Terms(D, h_S - cross(s, p) / M, s / M, p / M)

    at_beta = X @ beta, beta[0]
    by_one = jax.vmap(lambda *d: jax.jvp(about_cm, at_beta, d)[1], (1, 0), -1)
    return by_one(X, jnp.zeros(beta.size).at[0].set(1.0))
