"""Rows of unit quaternions, scalar last, in plain NumPy."""

import numpy as np
from jaxtyping import Float

Quaternions = Float[np.ndarray, "#n 4"]
Vectors = Float[np.ndarray, "#n 3"]


def product(x: Quaternions, y: Quaternions) -> Quaternions:
    """`R(x y) = R(x) R(y)`."""
    u, v = x[:, :3], y[:, :3]
    a, b = x[:, 3:], y[:, 3:]
    vector = a * v + b * u + np.cross(u, v)
    scalar = a * b - np.sum(u * v, axis=1, keepdims=True)
    return np.concatenate([vector, scalar], axis=1)


def conjugate(x: Quaternions) -> Quaternions:
    """`R(x*) = R(x)^T`."""
    return x * np.array([-1.0, -1.0, -1.0, 1.0])


def rotate_by_quaternion(x: Quaternions, v: Vectors) -> Vectors:
    """`R(x) v = v + 2 u x (u x v + a v)`, with `x = (u, a)`."""
    u, a = x[:, :3], x[:, 3:]
    return v + 2 * np.cross(u, np.cross(u, v) + a * v)
