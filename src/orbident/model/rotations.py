"""Rotations and cross products. Quaternions are `[x, y, z, w]`, Hamilton."""

import numpy as np
from jaxtyping import Float

from orbident.robot.parameters import cross_matrix

UNTURNED = np.array([0.0, 0.0, 0.0, 1.0])
"""The quaternion of no rotation."""


def rotate(
    R: Float[np.ndarray, "*#n 3 m"], v: Float[np.ndarray, "*#n m"]
) -> Float[np.ndarray, "*#n 3"]:
    """`R v`, for a rotation or any other matrix with three rows."""
    return (R @ v[..., None])[..., 0]


def rotate_back(
    R: Float[np.ndarray, "*#n 3 3"], v: Float[np.ndarray, "*#n 3"]
) -> Float[np.ndarray, "*#n 3"]:
    """`R^T v`."""
    return rotate(np.swapaxes(R, -1, -2), v)


def axis_rotation(
    axis: Float[np.ndarray, "*n 3"], angle: Float[np.ndarray, "*n"]
) -> Float[np.ndarray, "*n 3 3"]:
    """Rodrigues: the rotation by `angle` (rad) about the unit vector `axis`."""
    c, s = np.cos(angle)[..., None, None], np.sin(angle)[..., None, None]
    outer = axis[..., :, None] * axis[..., None, :]
    return c * np.eye(3) + s * cross_matrix(axis) + (1 - c) * outer


def quaternion_matrix(x_WB: Float[np.ndarray, "*n 4"]) -> Float[np.ndarray, "*n 3 3"]:
    """`R_WB` of a quaternion of any nonzero norm."""
    x, y, z, w = np.moveaxis(x_WB, -1, 0)
    # Dividing by the squared norm makes R orthogonal to rounding, whatever the norm.
    s = 2 / (x * x + y * y + z * z + w * w)
    rows = [
        [1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)],
        [s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w)],
        [s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def quaternion_rate(
    x_WB: Float[np.ndarray, "*n 4"], w_B: Float[np.ndarray, "*n 3"]
) -> Float[np.ndarray, "*n 4"]:
    """`d/dt x_WB = 1/2 x_WB (w, 0)`, with `w_B` the rate of B in W, B's axes, rad/s."""
    v, s = x_WB[..., :3], x_WB[..., 3:]
    vector = s * w_B + np.cross(v, w_B)
    scalar = -np.sum(v * w_B, axis=-1, keepdims=True)
    return 0.5 * np.concatenate([vector, scalar], axis=-1)


def rotation_angle(
    x_WA: Float[np.ndarray, "*#n 4"], x_WB: Float[np.ndarray, "*#n 4"]
) -> Float[np.ndarray, "*n"]:
    """The angle between two attitudes, rad; accurate down to rounding."""
    a = x_WA / np.linalg.norm(x_WA, axis=-1, keepdims=True)
    b = x_WB / np.linalg.norm(x_WB, axis=-1, keepdims=True)
    # The lengths are 2 sin and 2 cos of a quarter of it; of a and -a the nearer counts.
    apart = np.linalg.norm([a - b, a + b], axis=-1)
    return 4 * np.arctan2(apart.min(axis=0), apart.max(axis=0))
