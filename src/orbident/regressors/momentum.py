"""The momentum of one sample, linear in `theta` (theory: Eqs. 3 and 19).

`S theta` is the first moment about the feature point S, `P theta` the linear momentum
relative to S and `A theta` the angular momentum about S, all in base axes; the
angular momentum about the system CM is

    h_rs = A theta - (S theta) x (P theta) / M.
"""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Float

from orbident.dynamics.kinematics import velocities
from orbident.dynamics.tree import Tree, poses
from orbident.spatial.arrays import AnyArray
from orbident.spatial.rotations import cross, cross_matrix, product, rotate_back


class Momentum(eqx.Module):
    """The regressors of one sample; columns are the flat `theta`, base first."""

    S: Float[AnyArray, "3 theta"]
    P: Float[AnyArray, "3 theta"]
    A: Float[AnyArray, "3 theta"]


def momentum(
    tree: Tree,
    q: Float[AnyArray, " joints"],
    qd: Float[AnyArray, " joints"],
    w: Float[AnyArray, "3"],
) -> Momentum:
    """`S`, `P` and `A` at joint state `q, qd` and base rate `w` (rad/s, base axes)."""
    at = poses(tree, q)
    v = velocities(tree, at, qd, w)
    R, d = at.R, at.d
    w_x = cross_matrix(v.w)
    wR = product(w_x, R)
    none = jnp.zeros((*d.shape, 6), d.dtype)
    # m_i v_i + w_i x R_i s_i
    S = _beside(d[:, :, None], R, none)
    P = _beside(v.v[:, :, None], wR, none)
    # d_i x (m_i v_i + w_i x R_i s_i) + R_i s_i x v_i + R_i J_i R_i^T w_i
    A_m = cross(d, v.v)[:, :, None]
    A_s = product(cross_matrix(d), wR) - product(cross_matrix(v.v), R)
    A_J = product(R, _inertia_columns(rotate_back(R, v.w)))
    return Momentum(S, P, _beside(A_m, A_s, A_J))


def _beside(*parts: Float[AnyArray, "bodies 3 _"]) -> Float[AnyArray, "3 theta"]:
    """Mass, first-moment and inertia columns of each body, body after body."""
    # Turning each part before they are joined takes XLA half the time of after.
    turned = [jnp.swapaxes(part, 0, 1) for part in parts]
    return jnp.concatenate(turned, axis=-1).reshape(3, -1)


def _inertia_columns(w: Float[AnyArray, "n 3"]) -> Float[AnyArray, "n 3 6"]:
    """`L(w)` such that `J w = L(w) [Jxx, Jxy, Jyy, Jxz, Jyz, Jzz]`."""
    x, y, z = w[:, 0], w[:, 1], w[:, 2]
    o = jnp.zeros_like(x)
    rows = [[x, y, o, z, o, o], [o, x, y, o, z, o], [o, o, o, x, y, z]]
    return jnp.stack([jnp.stack(row, axis=-1) for row in rows], axis=-2)
