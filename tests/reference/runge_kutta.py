"""The classical Runge-Kutta method of fourth order, one step at a time."""

from collections.abc import Callable

import numpy as np
from obvious_momentum import quaternion_rotation


def step(rate: Callable, x: np.ndarray, dt: float, nodes: tuple) -> np.ndarray:
    """`rate(node, x)` holds at the start, twice at the middle, and at the end."""
    start, middle, end = nodes
    k_1 = rate(start, x)
    k_2 = rate(middle, x + dt / 2 * k_1)
    k_3 = rate(middle, x + dt / 2 * k_2)
    k_4 = rate(end, x + dt * k_3)
    return x + dt / 6 * (k_1 + 2 * k_2 + 2 * k_3 + k_4)


def quaternion_rate(x: np.ndarray, w: np.ndarray) -> np.ndarray:
    """`1/2 x (w, 0)`, scalar last."""
    return 0.5 * np.append(x[3] * w + np.cross(x[:3], w), -x[:3] @ w)


def attitudes(E, b, h_cm, x_WB, dt) -> np.ndarray:
    """After each step of `w = E R_0^T h_cm - b`; nodes are ends and middles."""

    def rate(k: int, x: np.ndarray) -> np.ndarray:
        R_WB = quaternion_rotation(x / np.linalg.norm(x))
        return quaternion_rate(x, E[k] @ R_WB.T @ h_cm[k] - b[k])

    path = [x_WB]
    for k, length in enumerate(dt):
        x = step(rate, path[-1], length, (2 * k, 2 * k + 1, 2 * k + 2))
        path.append(x / np.linalg.norm(x))
    return np.array(path)
