"""How the unknowns that are no parameters change from sample to sample.

    h_cm' = (integral of R_0) (b_g + n) x h_cm    where the attitude is integrated
    v_cm' = (integral of R_0) b_a + white         where the velocity is
    b_g' = white,   b_a' = white

The axes in which momentum and velocity are known drift with the sensors; in these axes
both constants do.
"""

import numpy as np

from orbident.dynamics.loops.vectors import cross
from orbident.estimation.recursive.folding import fold
from orbident.loops import looped


@looped
def moved(model, noise, state, R_WB, h_cm, dt):
    """The rows `[N | Y | z]`, of `N x + Y y = z`, for the nuisances a time later.

    With `x_before = back x - kick w`, `w` of unit variance, they are what is left of

        w = 0
        -N kick w + N back x + Y y = z

    without `w`.

    Args:
        model: of the robot.
        noise: of its sensors.
        state: before; its nuisances are `x = [h_cm, v_cm, b_g, b_a]`.
        R_WB: now.
        h_cm: the momentum known so far, N m s.
        dt: since then, s.

    Returns:
        As many rows, and their nuisances are upper triangular again.
    """
    top, n_h, n_v = state.top, len(model.turning), len(model.moving)
    n, columns = top.shape
    b_v = n_v if noise.accelerometer else 0
    walks = 2 * (n_h + b_v)
    rows = np.zeros((n, walks + columns))
    for i in range(n):
        for j in range(columns):
            rows[i, walks + j] = top[i, j]
    b_g = n_h + n_v
    _kick(noise.velocity_walk * np.sqrt(dt), top, n_h, rows, n_h, b_v)
    _kick(noise.gyro_walk * np.sqrt(dt), top, b_g, rows, n_h + b_v, n_h)
    last = noise.accelerometer_walk * np.sqrt(dt)
    _kick(last, top, b_g + n_h, rows, walks - b_v, b_v)
    # The integral of R_0 over the step.
    integral = np.empty((3, 3))
    for i in range(3):
        for j in range(3):
            integral[i, j] = dt / 2 * (state.R_WB[0, i, j] + R_WB[0, i, j])
    _turn(model, noise, top, integral, h_cm, rows, walks)
    if noise.accelerometer:
        _drift(model, top, integral, rows, walks)
    before = np.zeros((walks, walks + columns))
    for k in range(walks):
        before[k, k] = 1.0
    fold(before, rows, 0, walks)
    after = np.zeros((n, columns))
    fold(after, rows, walks, n)
    return after


@looped
def _kick(std, N, first, rows, column, count):
    """`-N kick` of so many unknowns that walk."""
    for i in range(len(N)):
        for j in range(count):
            rows[i, column + j] = -std * N[i, first + j]


@looped
def _turn(model, noise, N, integral, h_cm, rows, walks):
    """`h_cm` turns with an integrated attitude: by the bias, and by the noise."""
    h = model.turning
    bias = walks + len(h) + len(model.moving)
    for j in range(len(h)):
        column = integral[0, h[j]], integral[1, h[j]], integral[2, h[j]]
        turn = cross(column, h_cm)
        for k in range(len(h)):
            for i in range(len(N)):
                by_turn = noise.integrated * N[i, k] * turn[h[k]]
                rows[i, bias + j] -= by_turn
                rows[i, j] -= noise.gyro * by_turn


@looped
def _drift(model, N, integral, rows, walks):
    """`v_cm` drifts with the accelerometer's bias."""
    h, v = model.turning, model.moving
    bias = walks + 2 * len(h) + len(v)
    for j in range(len(v)):
        for k in range(len(v)):
            for i in range(len(N)):
                rows[i, bias + j] -= N[i, len(h) + k] * integral[v[k], v[j]]
