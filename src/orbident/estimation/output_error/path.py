"""The attitude along a segment, and what it depends on.

With `phi` the small rotation of the base, in its own axes, momentum conservation gives

    phi' = A phi + G,   A = E [h_B]x - [w]x,   G = E (R_0^T dh_cm - dD w - dh_q)

with `E = D^-1` and `h_B = R_0^T h_cm`; the last two terms are changes of the inertia's
terms. A change of the base rate is `dw = E [h_B]x phi + G`.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Float

from orbident.dynamics.attitude import RateLaw, attitudes
from orbident.dynamics.free_floating import Terms
from orbident.spatial.arrays import AnyArray
from orbident.spatial.rotations import (
    cross_matrix,
    inverse,
    product,
    quaternion_matrix,
    quaternion_rate,
    rotate,
    rotate_back,
)

ROW, MIDDLE, NEXT = slice(0, -1, 2), slice(1, None, 2), slice(2, None, 2)
"""Nodes: each row, half-way to the next, and the next row."""


class Path(NamedTuple):
    """The base at the nodes."""

    x_WB: Float[AnyArray, "nodes 4"]
    R_WB: Float[AnyArray, "nodes 3 3"]
    E: Float[AnyArray, "nodes 3 3"]
    h_B: Float[AnyArray, "nodes 3"]
    w: Float[AnyArray, "nodes 3"]


class Changes(NamedTuple):
    """How the base changes with each unknown, last axis; base axes."""

    phi: Float[AnyArray, "nodes 3 unknowns"]
    w: Float[AnyArray, "nodes 3 unknowns"]


def path_of(
    planar: bool,
    terms: Terms,
    h_rw: Float[AnyArray, "nodes 3"],
    dt: Float[AnyArray, " rows"],
    x_WB: Float[AnyArray, "4"],
    h_cm: Float[AnyArray, "nodes 3"],
) -> Path:
    """From the attitude at the first row."""
    law = _law(planar, terms.D, terms.h_q + h_rw)
    nodes = (
        (RateLaw(law.E[part], law.b[part]), h_cm[part]) for part in (ROW, MIDDLE, NEXT)
    )
    x = jnp.concatenate([x_WB[None], attitudes(x_WB, dt, *nodes)])
    rate = quaternion_rate(x, law.every(2).rate(x, h_cm[::2]))
    middle = _half_way(x, rate, dt)
    x = _interleaved(x, middle / jnp.linalg.norm(middle, axis=-1, keepdims=True))
    R_WB = quaternion_matrix(x)
    return Path(x, R_WB, law.E, rotate_back(R_WB, h_cm), law.rate(x, h_cm))


def refined(
    x: Float[AnyArray, " nodes *k"], substeps: int
) -> Float[AnyArray, " fine *k"]:
    """At the nodes of so many equal steps a row, by the parabola through its nodes.

    The joints move slowly; a base that nutates fast needs smaller steps than they do.
    """
    s = jnp.arange(2 * substeps) / (2 * substeps)
    parabola = jnp.stack([(1 - s) * (1 - 2 * s), 4 * s * (1 - s), s * (2 * s - 1)])
    three = jnp.stack([x[ROW], x[MIDDLE], x[NEXT]])
    fine = jnp.einsum("ls,lr...->rs...", parabola, three)
    return jnp.concatenate([fine.reshape(-1, *x.shape[1:]), x[-1:]])


def _law(
    planar: bool, D: Float[AnyArray, "n 3 3"], h_moving: Float[AnyArray, "n 3"]
) -> RateLaw:
    """`rate_law` in JAX."""
    E = jnp.zeros(D.shape).at[:, 2, 2].set(1 / D[:, 2, 2]) if planar else inverse(D)
    return RateLaw(E, rotate(E, h_moving))


def changes_of(
    path: Path,
    dt: Float[AnyArray, " rows"],
    turn: Float[AnyArray, "3 unknowns"],
    h_cm: Float[AnyArray, "nodes 3 unknowns"],
    terms: Terms,
) -> Changes:
    """By all unknowns at once.

    Args:
        path: the base.
        dt: from row to row, s.
        turn: changes of the first attitude, base axes.
        h_cm: changes of the momentum, inertial axes.
        terms: changes of the terms, last axis.
    """
    by_phi = product(path.E, cross_matrix(path.h_B))
    A = by_phi - cross_matrix(path.w)
    dD_w = jnp.einsum("nijc,nj->nic", terms.D, path.w)
    from_h = jnp.swapaxes(path.R_WB, 1, 2) @ h_cm
    G = product(path.E, from_h - dD_w - terms.h_q)

    h = dt[:, None, None]
    (A_0, A_1, A_2), (G_0, G_1, G_2) = (
        [X[p] for p in (ROW, MIDDLE, NEXT)] for X in (A, G)
    )

    def after_a_step(phi, G_0, G_1, G_2):
        """RK4."""
        k_1 = product(A_0, phi) + G_0
        k_2 = product(A_1, phi + h / 2 * k_1) + G_1
        k_3 = product(A_1, phi + h / 2 * k_2) + G_1
        k_4 = product(A_2, phi + h * k_3) + G_2
        return phi + h / 6 * (k_1 + 2 * k_2 + 2 * k_3 + k_4)

    transition = after_a_step(jnp.broadcast_to(jnp.eye(3), A_0.shape), 0.0, 0.0, 0.0)
    added = after_a_step(jnp.zeros_like(G_0), G_0, G_1, G_2)

    def step(phi, matrices):
        phi = product(matrices[0], phi) + matrices[1]
        return phi, phi

    later = jax.lax.scan(step, turn, (transition, added))[1]
    phi = jnp.concatenate([turn[None], later])
    rate = product(A[::2], phi) + G[::2]
    phi = _interleaved(phi, _half_way(phi, rate, dt))
    return Changes(phi, product(by_phi, phi) + G)


def _half_way(
    x: Float[AnyArray, " ends *k"],
    rate: Float[AnyArray, " ends *k"],
    dt: Float[AnyArray, " rows"],
) -> Float[AnyArray, " rows *k"]:
    """By the cubic through values and rates at both ends."""
    h = dt.reshape(-1, *(1,) * (x.ndim - 1))
    return (x[:-1] + x[1:]) / 2 + h / 8 * (rate[:-1] - rate[1:])


def _interleaved(
    x: Float[AnyArray, " ends *k"], between: Float[AnyArray, " rows *k"]
) -> Float[AnyArray, " nodes *k"]:
    both = jnp.stack([x[:-1], between], axis=1).reshape(-1, *x.shape[1:])
    return jnp.concatenate([both, x[-1:]])
