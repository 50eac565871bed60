"""Plain recursive least squares: Eq. 24 for `pi`, Eq. 31 for `phi`, Eq. 32 for `M`.

    K = P A^T (r^2 I + A P A^T)^-1,   x <- x + K (z - A x),   P <- (I - K A) P

The noise `r` is taken for white, and deviations are scaled by the residuals at the end.
"""

import numpy as np
from answers import Answer
from problem_folder import named

from baselines.equations import equations_of
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot

VAGUE = 10.0
"""Deviations at first, over the size of what is estimated."""


def recursive_least_squares(
    robot: Robot, recording: Recording, momentum: str
) -> Answer:
    """Estimate from one sample after the other."""
    e = equations_of(robot, recording, momentum)
    sizes = _sizes(e.sets.pi(robot.theta)), _sizes(e.sets.phi(robot.theta))
    r_h, r_v = e.noise(robot)
    pi, pi_std = recursion(e.Y, e.N_h, e.z_h, r_h, sizes[0])
    phi, phi_std = recursion(e.W, e.N_v, e.z_v, r_v, sizes[1])
    M, M_std = mass_by_products(e.sets, pi, pi_std, phi)
    return Answer({**named(pi, phi), "M": M}, {**named(pi_std, phi_std), "M": M_std})


def recursion(A, N, z, r, sizes) -> tuple[np.ndarray, np.ndarray]:
    """The unknowns of `[A N] x = z`, without those of N, and their deviations."""
    A = np.concatenate([A, N], axis=2)
    scale = np.concatenate([sizes, np.full(N.shape[2], np.abs(z).max())])
    x, P, squares = np.zeros(scale.size), np.diag((VAGUE * scale) ** 2), 0.0
    for A_k, z_k in zip(A, z, strict=True):
        S = r**2 * np.eye(len(z_k)) + A_k @ P @ A_k.T
        K = np.linalg.solve(S, A_k @ P).T
        error = z_k - A_k @ x
        squares += error @ np.linalg.solve(S, error)
        x = x + K @ error
        P = P - K @ (A_k @ P)
        P = (P + P.T) / 2
    variance = squares / max(z.size - scale.size, 1)
    std = np.sqrt(variance * np.maximum(np.diag(P), 0.0))
    return x[: sizes.size], std[: sizes.size]


def mass_by_products(sets, pi, pi_std, phi) -> tuple[float, float]:
    """`pi_i = M g_i(phi)` where `pi_i` holds no inertia: weighted least squares."""
    a, b = sets.pairs.T
    sigmas = slice(1, 1 + phi.size)
    g = sets.pi_of_beta[:, 0] + sets.pi_of_beta[:, sigmas] @ phi
    g = (g + sets.pi_of_products @ (phi[a] * phi[b]))[sets.iotas :]
    weights = g / pi_std[sets.iotas :] ** 2
    return float(weights @ pi[sets.iotas :] / (weights @ g)), float(
        1 / np.sqrt(weights @ g)
    )


def _sizes(values: np.ndarray) -> np.ndarray:
    return np.maximum(np.abs(values), 1e-3 * np.abs(values).max())
