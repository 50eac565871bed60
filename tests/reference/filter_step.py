"""One step of the recursive filter: its equations by textbook formulas, body by body.

Nothing is carried in triangular factors here, and noise is whitened by the covariance
of all rows at once.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from obvious_momentum import system_motion
from scipy.linalg import block_diag
from scipy.spatial.transform import Rotation

from orbident.estimation.recursive.filter import Sample, State
from orbident.estimation.recursive.filter_input import Noise
from orbident.model.minimal_sets import MinimalSets, minimal_sets
from orbident.robot.description import Robot
from orbident.robot.parameters import cross_matrix


class Axes(NamedTuple):
    h: np.ndarray
    v: np.ndarray


def axes_of(sets: MinimalSets) -> Axes:
    own = sets.regressors
    return Axes(np.array(own.momentum_axes), np.array(own.velocity_axes))


def spread(vector: np.ndarray, axes: np.ndarray) -> np.ndarray:
    full = np.zeros(3)
    full[axes] = vector
    return full


def transition(
    noise: Noise, state: State, sample: Sample, axes: Axes
) -> tuple[np.ndarray, np.ndarray]:
    """`x_before = back x - kick w`."""
    h, v = axes
    n_h, n_v = h.size, v.size
    n = len(state.top)
    dt = sample.t - state.t
    turned = rotation(sample) + state.R_WB
    integral = dt * turned / 2
    momentum = spread(state.nuisances[:n_h], h) + sample.h_given
    turn = noise.integrated * (-cross_matrix(momentum) @ integral)[np.ix_(h, h)]
    driven = noise.driven.table
    first = n_h + n_v + len(driven)
    back, bias = np.eye(n), np.arange(first, first + n_h)
    back[np.ix_(np.arange(n_h), bias)] -= turn
    speeds, last = (
        np.arange(n_h, n_h + n_v),
        np.arange(bias[-1] + 1, bias[-1] + 1 + n_v),
    )
    kicks = [
        (np.arange(n_h), noise.gyro * turn),
        (np.arange(n_h), noise.momentum_walk * np.sqrt(dt) * np.eye(n_h)),
        (speeds, noise.velocity_walk * np.sqrt(dt) * np.eye(n_v)),
        (bias, noise.gyro_walk * np.sqrt(dt) * np.eye(n_h)),
        (np.arange(n_h + n_v, first), np.sqrt(dt) * np.diag(driven[:, 1])),
    ]
    if noise.accelerometer:
        back[np.ix_(speeds, last)] -= integral[np.ix_(v, v)]
        kicks.append((last, noise.accelerometer_walk * np.sqrt(dt) * np.eye(n_v)))
    every = []
    for rows, of in kicks:
        every.append(np.zeros((n, of.shape[1])))
        every[-1][rows] = of
    return back, np.hstack(every)


def rotation(sample: Sample) -> np.ndarray:
    return Rotation.from_quat(sample.x_WB).as_matrix()


class Laws(NamedTuple):
    """Both conservation laws of a sample, momentum first."""

    rows: np.ndarray
    """`[h_cm, v_cm, b_g, b_a, pi, phi | rhs]`."""
    of_gyro: np.ndarray
    """What noise of unit variance on each axis of the gyro adds."""
    covariance: np.ndarray
    """The covariance of their noise, each law's as if it were independent."""


def laws(robot: Robot, noise: Noise, state: State, sample: Sample, axes: Axes) -> Laws:
    """The rows by textbook formulas."""
    sets = minimal_sets(robot)
    h, v = axes
    R_BW = rotation(sample).T
    theta = (sets.base.theta_of @ state.beta).reshape(-1, 10)
    at_beta = replace(robot, theta=theta)
    D_full, D_q, r_cm, J_cm = inertia(at_beta, sample.q)
    D = D_full[np.ix_(h, h)]
    U = -cross_matrix(r_cm)[np.ix_(v, h)]
    excess = (sample.w - sample.w_smooth)[h]
    w = np.array(sample.w)
    w[h] -= excess
    Y, W = regressors(robot, sets, sample.q, sample.qd, w)
    b_a = np.zeros((h.size, v.size if noise.accelerometer else 0))
    b_v = np.zeros((v.size, b_a.shape[1]))
    none_h, none_v = np.zeros((h.size, v.size)), np.zeros((v.size, h.size))
    no_phi, no_pi = np.zeros((h.size, W.shape[1])), np.zeros((v.size, Y.shape[1]))
    A_rw = np.array([wheel.inertia * wheel.axis for wheel in robot.wheels])
    h_rw = sample.qd_rw @ A_rw.reshape(-1, 3)
    rhs_h = (R_BW @ sample.h_given - h_rw)[h] - D @ excess
    rhs_v = (R_BW @ sample.v_S)[v] + U @ excess
    R_h, R_v = R_BW[np.ix_(h, h)], R_BW[np.ix_(v, v)]
    K = len(noise.driven.table)
    p_h, d_h, p_v, d_v = (np.zeros((x.size, k * K)) for x in (h, v) for k in (1, 5))
    momentum = np.hstack([-R_h, none_h, p_h, -D, b_a, d_h, Y, no_phi, rhs_h[:, None]])
    velocity = np.hstack([none_v, R_v, p_v, U, b_v, d_v, no_pi, W, rhs_v[:, None]])
    momentum_then = spread(state.nuisances[: h.size], h) + sample.h_given
    turn = (R_BW @ cross_matrix(momentum_then))[h]
    D_q, J_cm = D_q[h], J_cm[v]
    G_h, G_v = noise.gyro * D, -noise.gyro * U
    C_h = np.hstack([G_h, noise.joint_rates * D_q, noise.attitude * turn])
    C_v = np.hstack([G_v, noise.joint_rates * J_cm, noise.velocity * np.eye(v.size)])
    return Laws(
        np.vstack([momentum, velocity]),
        np.vstack([G_h, G_v]),
        np.asarray(block_diag(C_h @ C_h.T, C_v @ C_v.T)),
    )


def white_equations(
    top: np.ndarray, kick: np.ndarray, own: Laws, momenta: int
) -> np.ndarray:
    """The rows of the nuisances and of a sample, by the covariance of all their noise.

    Args:
        top: rows of the nuisances, with noise of unit variance,
        kick: and what noise of unit variance adds to them, that of the gyro first.
        own: the sample's, over the same unknowns.
        momenta: how many axes of the gyro count.
    """
    C = np.eye(len(top)) + kick @ kick.T
    shared = own.of_gyro @ kick[:, :momenta].T
    # What the laws share beyond this is left out.
    between = shared @ np.linalg.solve(C, shared.T)
    between[:momenta, :momenta] = between[momenta:, momenta:] = 0.0
    joint = np.block([[C, shared.T], [shared, own.covariance + between]])
    return np.linalg.solve(np.linalg.cholesky(joint), np.vstack([top, own.rows]))


def inertia(robot: Robot, q: np.ndarray) -> tuple[np.ndarray, ...]:
    """`D`, `D_q`, `r_cm` and `J_cm` from the momentum of unit rates."""
    joints, still = q.size, np.zeros(3)
    turns = [system_motion(robot, q, np.zeros(joints), e) for e in np.eye(3)]
    swings = [system_motion(robot, q, e, still) for e in np.eye(joints)]
    D, D_q = (np.array([at.h_rs for at in unit]).T for unit in (turns, swings))
    M, r_cm = robot.mass, turns[0].first_moment
    J_cm = np.array([at.linear for at in swings]).T
    return D, D_q, r_cm / M, J_cm / M


def regressors(
    robot: Robot, sets: MinimalSets, q: np.ndarray, qd: np.ndarray, w: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """`Y` and `W`: what every unit of `pi` and `phi` adds to momentum and velocity.

    `Y pi` is the angular momentum about the CM and `-W phi` the velocity of the CM
    relative to S, of as many robots as determine all columns.
    """
    axes, pis, phis, momenta, speeds = axes_of(sets), [], [], [], []
    for theta in robots_that_determine(robot, sets):
        at = system_motion(replace(robot, theta=theta), q, qd, w)
        pis.append(sets.pi(theta))
        phis.append(sets.phi(theta))
        momenta.append(at.h_rs[axes.h])
        speeds.append(-at.linear[axes.v] / theta[:, 0].sum())
    Y = np.linalg.lstsq(np.array(pis), np.array(momenta), rcond=None)[0].T
    W = np.linalg.lstsq(np.array(phis), np.array(speeds), rcond=None)[0].T
    return Y, W


def robots_that_determine(robot: Robot, sets: MinimalSets) -> list[np.ndarray]:
    """As many `theta` as determine all columns of a regressor."""
    random = np.random.default_rng(0)
    may = np.zeros(robot.theta.size, dtype=bool)
    may[list(robot.free_parameters)] = True
    may, sizes = may.reshape(robot.theta.shape), np.abs(robot.theta).max(axis=0)
    thetas = []
    for _ in range(2 * len(sets.pi_of_beta) + 10):
        theta = robot.theta * random.uniform(0.2, 2.0, robot.theta.shape)
        none = may & (theta == 0.0)
        theta += np.where(none, sizes * random.uniform(0.1, 1.0, theta.shape), 0.0)
        thetas.append(theta)
    return thetas


def information(rows: np.ndarray, eliminated: int) -> np.ndarray:
    """`A^T A` of `[A | b]` with the first unknowns eliminated."""
    R = np.asarray(np.linalg.qr(rows, mode="r"))[eliminated:, eliminated:]
    return R.T @ R
