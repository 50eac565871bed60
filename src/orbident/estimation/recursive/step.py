"""One sample, or all of a recording, into the factors of the extended filter."""

import numpy as np

from orbident.dynamics.loops.bodies import room
from orbident.dynamics.loops.matrices import add_scaled, applied, assign, dot, finite
from orbident.dynamics.loops.vectors import put, quaternion_matrix, row
from orbident.estimation.recursive.equations import (
    complete,
    equations,
    inertia_at,
    measured,
    model_in,
    momentum_of_wheels,
)
from orbident.estimation.recursive.folding import fold, fold_columns, solved
from orbident.estimation.recursive.linear_sets import LinearSets, linear_sets_at
from orbident.estimation.recursive.noise import Noise
from orbident.estimation.recursive.state import parts_of
from orbident.estimation.recursive.transition import move_on
from orbident.loops import looped


@looped
def step(model, noise, sets, sizes, packed, t, sample):
    """`Extended.step`: the packed state after it, and its `Info`."""
    model, noise, sets = model_in(model), Noise(*noise), LinearSets(*sets)
    at, rows = measured(model, sample), len(model.turning) + len(model.moving)
    if not _counts(parts_of(sizes, packed), t, at):
        return packed, (np.zeros(rows), 0.0, 0)
    packed = packed.copy()
    after = parts_of(sizes, packed)
    white = _take_in(model, noise, after, t, at)
    assign(after.nuisances, _nuisances(after.top, _newton(sets, after)))
    dof = rows if finite(at.v_S) else len(model.turning)
    return packed, (white, dot(white, white), dof)


@looped
def gather(model, noise, sizes, packed, t, samples):
    """`Extended.gathered`: the packed state, squared residuals, and their number."""
    model, noise, packed = model_in(model), Noise(*noise), packed.copy()
    after, squares, dof = parts_of(sizes, packed), 0.0, 0
    for k in range(len(t)):
        at = measured(model, samples[k])
        if _counts(after, t[k], at):
            white = _take_in(model, noise, after, t[k], at)
            squares += dot(white, white)
            dof += len(white) if finite(at.v_S) else len(model.turning)
    return packed, squares, dof


@looped
def _counts(state, t, at):
    """Whether a sample is complete, later than the last one, and of a live gyro."""
    return not t <= state.t[0] and complete(at) and not _same(at.w, state.w)


@looped
def _take_in(model, noise, state, t, at):
    """Its equations, into the factors in place; returns the whitened innovation."""
    x, n = state.nuisances, len(state.nuisances)
    h_cm = (0.0, 0.0, x[0]) if len(model.turning) == 1 else (x[0], x[1], x[2])
    R_WB = quaternion_matrix(at.x_WB[0], at.x_WB[1], at.x_WB[2], at.x_WB[3])
    dt = 0.0 if np.isnan(state.t[0]) else t - state.t[0]
    rows = equations(model, noise, state.beta, h_cm, at, R_WB)
    move_on(model, noise, state, R_WB, h_cm, dt)
    fold(state.top, rows, 0, n)
    fold(state.R_z, rows, n, len(state.R_z))
    state.t[0] = t
    for i in range(3):
        state.w[i] = at.w[i]
        put(state.R_WB[0], i, row(R_WB, 0, i))
    return rows[:, -1].copy()


@looped
def _same(a, b):
    equal = True
    for i in range(len(a)):
        equal = equal and a[i] == b[i]
    return equal


@looped
def _newton(sets, after):
    """A step of Gauss and Newton from the last `beta`, its root, and its `y`."""
    prior, R_z, k, n = after.prior, after.R_z, len(after.beta), len(after.R_z)
    _, tangent = linear_sets_at(sets, after.beta)
    columns, root_z = np.empty((k + 1, n)), np.zeros((k, k + 1))
    for i in range(n):
        for j in range(k):
            columns[j, i] = dot(R_z[i, i:n], tangent[j, i:])
        columns[k, i] = R_z[i, n] + dot(R_z[i, i:n], tangent[k, i:])
    for i in range(k):
        assign(root_z[i, i:k], prior.root[i, i:])
        root_z[i, k] = dot(prior.root[i], prior.beta)
    fold_columns(root_z, columns)
    assign(after.beta, solved(root_z))
    for i in range(k):
        assign(after.root[i], root_z[i])
    y = -tangent[k]
    for j in range(k):
        add_scaled(after.beta[j], tangent[j], y)
    return y


@looped
def _nuisances(top, y):
    """`x` of `N x + Y y = z`."""
    n = len(top)
    N_z = np.empty((n, n + 1))
    for i in range(n):
        assign(N_z[i, :n], top[i])
        N_z[i, n] = top[i, -1]
        for j in range(len(y)):
            N_z[i, n] -= top[i, n + j] * y[j]
    return solved(N_z)


@looped
def momentum(model, beta, sample):
    """`R_0 (D w + D_q qd + A_rw qd_rw)` (Eq. 2), and `R_0`."""
    model = model_in(model)
    at, joints = measured(model, sample), len(model.columns.joints.parent)
    bodies, H = room(joints + 1), np.zeros((6 + joints, 6 + joints))
    inertia_at(model, beta, at.q, bodies, H)
    h_B = np.array(momentum_of_wheels(model, at))
    for i in range(3):
        for j in range(3):
            h_B[i] += H[3 + max(i, j), 3 + min(i, j)] * at.w[j]
        for k in range(joints):
            h_B[i] += H[6 + k, 3 + i] * at.qd[k]
    R_WB = quaternion_matrix(at.x_WB[0], at.x_WB[1], at.x_WB[2], at.x_WB[3])
    return applied(R_WB[0], h_B), R_WB
