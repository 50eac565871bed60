"""How the unknowns that are no parameters change from sample to sample.

    h_cm' = (integral of R_0) (b_g + n) x h_cm    where the attitude is integrated
    v_cm' = (integral of R_0) b_a + white         where the velocity is
    b_g' = white,   b_a' = white

The axes in which momentum and velocity are known drift with the sensors; in these axes
both constants do.
"""

import numpy as np

from orbident.dynamics.loops.matrices import dot, whiten
from orbident.dynamics.loops.vectors import cross
from orbident.estimation.recursive.folding import fold
from orbident.loops import looped


@looped
def move_on(model, noise, state, R_WB, h_cm, dt):
    """The rows `[N | Y | z]`, of `N x + Y y = z`, for the nuisances a time later.

    With `x_before = back x - kick w`, `w` of unit variance, they are

        N back x + Y y = z + N kick w

    whitened: the noise of the right-hand side has the covariance `1 + K K^T`,
    `K = N kick`.

    Args:
        model: of the robot.
        noise: of its sensors.
        state: its `top` is replaced; the nuisances `x = [h_cm, v_cm, b_g, b_a]` are
            upper triangular again.
        R_WB: now.
        h_cm: the momentum known so far, N m s.
        dt: since then, s.
    """
    N, n_h, n_v = state.top, len(model.turning), len(model.moving)
    n, b_v = len(N), n_v if noise.accelerometer else 0
    b_g = n_h + n_v
    K = np.zeros((n, 2 * (n_h + b_v)))
    _kick(noise.velocity_walk * np.sqrt(dt), N, n_h, K, n_h, b_v)
    _kick(noise.gyro_walk * np.sqrt(dt), N, b_g, K, n_h + b_v, n_h)
    last = noise.accelerometer_walk * np.sqrt(dt)
    _kick(last, N, b_g + n_h, K, 2 * n_h + b_v, b_v)
    rows = N.copy()
    # The integral of R_0 over the step.
    integral = np.empty((3, 3))
    for i in range(3):
        for j in range(3):
            integral[i, j] = dt / 2 * (state.R_WB[0, i, j] + R_WB[0, i, j])
    _turn(model, noise, N, integral, h_cm, rows, K)
    if noise.accelerometer:
        _drift(model, N, integral, rows)
    C = np.empty((n, n))
    for i in range(n):
        for j in range(n):
            C[i, j] = dot(K[i], K[j])
        C[i, i] += 1.0
    whiten(C, rows)
    for i in range(n):
        for j in range(N.shape[1]):
            N[i, j] = 0.0
    fold(N, rows, 0, n)


@looped
def _kick(std, N, first, K, column, count):
    """Of so many unknowns that walk."""
    for i in range(len(N)):
        for j in range(count):
            K[i, column + j] = std * N[i, first + j]


@looped
def _turn(model, noise, N, integral, h_cm, rows, K):
    """`h_cm` turns with an integrated attitude: by the bias, and by the noise."""
    h = model.turning
    bias = len(h) + len(model.moving)
    for j in range(len(h)):
        column = integral[0, h[j]], integral[1, h[j]], integral[2, h[j]]
        turn = cross(column, h_cm)
        for k in range(len(h)):
            for i in range(len(N)):
                by_turn = noise.integrated * N[i, k] * turn[h[k]]
                rows[i, bias + j] -= by_turn
                K[i, j] += noise.gyro * by_turn


@looped
def _drift(model, N, integral, rows):
    """`v_cm` drifts with the accelerometer's bias."""
    h, v = model.turning, model.moving
    bias = 2 * len(h) + len(v)
    for j in range(len(v)):
        for k in range(len(v)):
            for i in range(len(N)):
                rows[i, bias + j] -= N[i, len(h) + k] * integral[v[k], v[j]]
