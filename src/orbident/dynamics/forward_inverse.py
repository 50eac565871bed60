"""From forces to accelerations, and back (Eq. 13)."""

import jax.numpy as jnp
from jax.scipy.linalg import cho_factor, cho_solve
from jaxtyping import Float

from orbident.dynamics.equations_of_motion import (
    Equations,
    Model,
    equations_of_motion,
)
from orbident.spatial.arrays import AnyArray


def forward_dynamics(
    model: Model,
    q: Float[AnyArray, " joints"],
    v: Float[AnyArray, " speeds"],
    Q: Float[AnyArray, " speeds"],
) -> Float[AnyArray, " speeds"]:
    """`v' = H+^-1 (Q - c+)`; in the plane, of what can move.

    Args:
        model: the robot's.
        q: joint positions, rad or m.
        v: generalised speeds, base axes.
        Q: generalised forces, base axes.

    Raises:
        InputError: `q` is not float64.
    """
    at = equations_of_motion(model, q, v)
    return accelerations(at, Q, jnp.zeros_like(v), model.free)


def inverse_dynamics(
    model: Model,
    q: Float[AnyArray, " joints"],
    v: Float[AnyArray, " speeds"],
    vd: Float[AnyArray, " speeds"],
) -> Float[AnyArray, " speeds"]:
    """`Q = H+ v' + c+`: what it takes; in the plane, with what the plane bears.

    Args:
        model: the robot's.
        q: joint positions, rad or m.
        v: generalised speeds, base axes.
        vd: their derivatives.

    Raises:
        InputError: `q` is not float64.
    """
    at = equations_of_motion(model, q, v)
    return at.H @ vd + at.c


def accelerations(
    at: Equations,
    Q: Float[AnyArray, " speeds"],
    vd: Float[AnyArray, " speeds"],
    free: Float[AnyArray, " speeds"],
) -> Float[AnyArray, " speeds"]:
    """`v'` where some of it is known, and elsewhere the force is.

    Args:
        at: the equations of motion in this state.
        Q: the forces where `free` is 1.
        vd: the accelerations where `free` is 0.
        free: 1 or 0 for each speed.
    """
    known = (1 - free) * vd
    # Rows and columns of what is known become those of the identity: one size for all.
    H_free = at.H * free * free[:, None] + jnp.diag(1 - free)
    return known + cho_solve(cho_factor(H_free), free * (Q - at.c - at.H @ known))
