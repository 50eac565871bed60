"""An extended Kalman filter on `theta`, the ten inertial parameters of every body.

    x = [theta, h_cm, v_cm, b],   nothing changes from sample to sample
    0 = Y pi(theta) + N_h h_cm - z_h + noise
    0 = W phi(theta) + N_v [v_cm; b] - z_v + noise

It starts from CAD, with 30 % of each body's mass and size as deviations. What free
floating does not show stays as CAD has it.
"""

import numpy as np
from answers import Answer
from problem_folder import named

from baselines.equations import equations_of
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot

UNCERTAIN = 0.3
LEAST_NOISE = 0.01
"""Over the RMS of what an equation has on its right. With the scatter alone the filter
diverges: it takes the errors of its first linearisations for knowledge."""


def theta_filter(robot: Robot, recording: Recording, momentum: str) -> Answer:
    """Estimate from one sample after the other."""
    e = equations_of(robot, recording, momentum)
    T, axes = e.sets.base.T, (e.N_h.shape[2], e.N_v.shape[2])
    sizes = np.sqrt(np.mean(e.z_h**2)), np.sqrt(np.mean(e.z_v**2))
    noise = np.maximum(e.noise(robot), LEAST_NOISE * np.array(sizes))
    noise = np.repeat(noise, (e.z_h.shape[1], e.z_v.shape[1]))
    x = np.concatenate([robot.theta.ravel(), np.zeros(sum(axes))])
    vague = np.repeat((10 * np.abs(e.z_h).max(), 10 * np.abs(e.z_v).max()), axes)
    P = np.diag(np.concatenate([_prior(robot), vague]) ** 2)
    n = robot.theta.size
    for Y, N_h, z_h, W, N_v, z_v in zip(*e[1:], strict=True):
        beta = T @ x[:n]
        pi, phi = _sets(e.sets, beta)
        dpi, dphi = e.sets.derivatives(beta)
        h_cm, v_cm = np.split(x[n:], [axes[0]])
        error = np.concatenate([z_h - Y @ pi - N_h @ h_cm, z_v - W @ phi - N_v @ v_cm])
        H = np.block(
            [
                [Y @ dpi @ T, N_h, np.zeros((len(z_h), axes[1]))],
                [W @ dphi @ T, np.zeros((len(z_v), axes[0])), N_v],
            ]
        )
        R = np.diag(noise**2)
        K = np.linalg.solve(H @ P @ H.T + R, H @ P).T
        x = x + K @ error
        # Joseph's form: P stays positive.
        left = np.eye(x.size) - K @ H
        P = left @ P @ left.T + K @ R @ K.T
    return _answer(e.sets, T @ x[:n], T @ P[:n, :n] @ T.T)


def _answer(sets, beta: np.ndarray, C: np.ndarray) -> Answer:
    pi, phi = _sets(sets, beta)
    std = [
        np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", J, C, J), 0.0))
        for J in sets.derivatives(beta)
    ]
    M_std = float(np.sqrt(C[0, 0]))
    return Answer({**named(pi, phi), "M": float(beta[0])}, {**named(*std), "M": M_std})


def _sets(sets, beta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    M, sigma, _ = sets.split(beta)
    a, b = sets.pairs.T
    products = sigma[a] * sigma[b] / M
    return sets.pi_of_beta @ beta + sets.pi_of_products @ products, sigma / M


def _prior(robot: Robot) -> np.ndarray:
    """Deviations of `theta`: none of what the robot file says is zero."""
    m, I = robot.theta[:, :1], robot.theta[:, [4, 6, 9]].sum(axis=1, keepdims=True)
    std = UNCERTAIN * np.hstack([m, np.repeat(np.sqrt(m * I / 2), 3, axis=1)])
    std = np.hstack([std, np.repeat(UNCERTAIN * I / 2, 6, axis=1)]).ravel()
    held = np.setdiff1d(np.arange(std.size), robot.free_parameters)
    std[held] = 0.0
    return std
