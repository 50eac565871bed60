"""Rotations and cross products in JAX. Quaternions are `[x, y, z, w]`, Hamilton."""

import jax.numpy as jnp
from jaxtyping import Float

from orbident.spatial.arrays import AnyArray


def cross(
    a: Float[AnyArray, "*#n 3"], b: Float[AnyArray, "*#n 3"]
) -> Float[AnyArray, "*#n 3"]:
    """`a x b`, over any leading axes."""
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    return jnp.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)


def cross_matrix(v: Float[AnyArray, "*n 3"]) -> Float[AnyArray, "*n 3 3"]:
    """`[v]x`, so that `[v]x u = v x u`."""
    x, y, z = v[..., 0], v[..., 1], v[..., 2]
    o = jnp.zeros_like(x)
    rows = [[o, -z, y], [z, o, -x], [-y, x, o]]
    return jnp.stack([jnp.stack(row, axis=-1) for row in rows], axis=-2)


def product(
    A: Float[AnyArray, "*#n 3 3"], B: Float[AnyArray, "*#n 3 m"]
) -> Float[AnyArray, "*#n 3 m"]:
    """`A B`, written out: it fuses, where XLA's product of tiny matrices does not."""
    terms = [A[..., :, k, None] * B[..., k, None, :] for k in range(3)]
    return terms[0] + terms[1] + terms[2]


def rotate(
    R: Float[AnyArray, "*#n 3 3"], v: Float[AnyArray, "*#n 3"]
) -> Float[AnyArray, "*#n 3"]:
    """`R v`."""
    terms = [R[..., :, k] * v[..., k, None] for k in range(3)]
    return terms[0] + terms[1] + terms[2]


def rotate_back(
    R: Float[AnyArray, "*#n 3 3"], v: Float[AnyArray, "*#n 3"]
) -> Float[AnyArray, "*#n 3"]:
    """`R^T v`."""
    terms = [R[..., k, :] * v[..., k, None] for k in range(3)]
    return terms[0] + terms[1] + terms[2]


def inverse(A: Float[AnyArray, "*n 3 3"]) -> Float[AnyArray, "*n 3 3"]:
    """`A^-1` by cofactors: it fuses and differentiates better than factors do."""
    a, b, c = A[..., 0, :], A[..., 1, :], A[..., 2, :]
    columns = jnp.stack([cross(b, c), cross(c, a), cross(a, b)], axis=-1)
    return columns / jnp.sum(a * cross(b, c), axis=-1)[..., None, None]


def axis_rotation(
    axis: Float[AnyArray, "*n 3"], angle: Float[AnyArray, "*n"]
) -> Float[AnyArray, "*n 3 3"]:
    """Rodrigues: the rotation by `angle` (rad) about the unit vector `axis`."""
    c, s = jnp.cos(angle)[..., None, None], jnp.sin(angle)[..., None, None]
    outer = axis[..., :, None] * axis[..., None, :]
    return c * jnp.eye(3) + s * cross_matrix(axis) + (1 - c) * outer


def quaternion_matrix(x_WB: Float[AnyArray, "*n 4"]) -> Float[AnyArray, "*n 3 3"]:
    """`R_WB` of a quaternion of any nonzero norm."""
    x, y, z, w = (x_WB[..., k] for k in range(4))
    # Dividing by the squared norm makes R orthogonal to rounding, whatever the norm.
    s = 2 / (x * x + y * y + z * z + w * w)
    rows = [
        [1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)],
        [s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w)],
        [s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y)],
    ]
    return jnp.stack([jnp.stack(row, axis=-1) for row in rows], axis=-2)


def quaternion_rate(
    x_WB: Float[AnyArray, "*n 4"], w_B: Float[AnyArray, "*n 3"]
) -> Float[AnyArray, "*n 4"]:
    """`d/dt x_WB = 1/2 x_WB (w, 0)`, with `w_B` the rate of B in W, B's axes, rad/s."""
    v, s = x_WB[..., :3], x_WB[..., 3:]
    vector = s * w_B + cross(v, w_B)
    scalar = -jnp.sum(v * w_B, axis=-1, keepdims=True)
    return 0.5 * jnp.concatenate([vector, scalar], axis=-1)


def small_rotation(
    x_WA: Float[AnyArray, "*n 4"], x_WB: Float[AnyArray, "*n 4"]
) -> Float[AnyArray, "*n 3"]:
    """The rotation vector from A to B, A's axes, rad; of a large angle `2 sin(a/2)`."""
    a, b = x_WA, x_WB
    # conj(a) b
    vector = a[..., 3:] * b[..., :3] - b[..., 3:] * a[..., :3]
    vector -= cross(a[..., :3], b[..., :3])
    scalar = jnp.sum(a * b, axis=-1, keepdims=True)
    return 2 * jnp.where(scalar < 0, -vector, vector)


def rotation_angle(
    x_WA: Float[AnyArray, "*n 4"], x_WB: Float[AnyArray, "*n 4"]
) -> Float[AnyArray, "*n"]:
    """The angle between two attitudes, rad; accurate down to rounding."""
    a = x_WA / jnp.linalg.norm(x_WA, axis=-1, keepdims=True)
    b = x_WB / jnp.linalg.norm(x_WB, axis=-1, keepdims=True)
    # sin and cos of half the angle are the two parts of conj(a) b.
    sine = jnp.linalg.norm(small_rotation(a, b), axis=-1) / 2
    return 2 * jnp.arctan2(sine, jnp.abs(jnp.sum(a * b, axis=-1)))
