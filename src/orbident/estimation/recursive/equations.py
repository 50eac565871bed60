"""The two conservation laws of one sample, linear in all unknowns.

In base axes, with the rate `w = w_gyro - b_g - n`,

    Y pi - R_0^T h_cm - D b_g = -A_rw qd_rw                     (Eqs. 2, 19)
    W phi + R_0^T v_cm + U b_g = R_0^T v_S                      (Eq. 29)

with `D = d h_rs / dw` and `U = d (velocity of the CM relative to S) / dw` at the
parameters known so far. The gyro's noise `n` adds `D n` and `-U n` on the right, and
the noise of attitude and joint rates adds to that. That of both laws counts as if each
had its own. What they have in common is told by `D` and `U`, and while these are wrong
by some ten percent it would be wrong.

`Y` and `W` are evaluated at a smoothed rate, and `D`, `U` take them to the gyro's.
Noise in a regressor is mistaken for excitation: as long as the base has hardly
changed its rate, least squares would find that it has no inertia.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from orbident.dynamics.loops.bodies import Joints, move, place, room, weigh
from orbident.dynamics.loops.mass_matrix import mass_matrix
from orbident.dynamics.loops.matrices import Sparse, applied, finite, whiten
from orbident.dynamics.loops.vectors import cross, load, plus, rotated_back, times
from orbident.dynamics.wheels import wheels_of
from orbident.loops import looped
from orbident.regressors.loops import Columns, columns_of, regressors
from orbident.regressors.minimal_sets import MinimalSets
from orbident.robot.description import Robot
from orbident.robot.parameters import PER_BODY


class Model(NamedTuple):
    """A robot's regressors, and a `theta` for every `beta`."""

    columns: Columns
    theta_of: Float[np.ndarray, "theta beta"]
    A_rw: Float[np.ndarray, "wheels 3"]
    turning: Int[np.ndarray, " h"]
    """Base axes in which angular momentum is conserved."""
    moving: Int[np.ndarray, " v"]
    """Base axes in which linear momentum is."""


def model_of(robot: Robot, sets: MinimalSets) -> Model:
    """What the filter needs of a robot."""
    own = sets.regressors
    return Model(
        columns=columns_of(own),
        theta_of=np.ascontiguousarray(sets.base.theta_of),
        A_rw=np.ascontiguousarray(wheels_of(robot).A_rw.T),
        turning=np.array(own.momentum_axes),
        moving=np.array(own.velocity_axes),
    )


def plain(parts: tuple) -> tuple:
    """Without names: Numba takes such a tuple in a fourth of the time."""
    return tuple(plain(part) if isinstance(part, tuple) else part for part in parts)


@looped
def model_in(parts):
    """The model of which these are the plain parts."""
    columns, theta_of, A_rw, turning, moving = parts
    joints, linear, sigma, first, second = columns
    columns = Columns(Joints(*joints), Sparse(*linear), Sparse(*sigma), first, second)
    return Model(columns, theta_of, A_rw, turning, moving)


class Measured(NamedTuple):
    """The parts of `Sample.packed` that the laws need."""

    q: Float[np.ndarray, " joints"]
    qd: Float[np.ndarray, " joints"]
    w: Float[np.ndarray, "3"]
    x_WB: Float[np.ndarray, "4"]
    qd_rw: Float[np.ndarray, " wheels"]
    v_S: Float[np.ndarray, "3"]
    w_smooth: Float[np.ndarray, "3"]
    drift: Float[np.ndarray, "9"]
    """By an accelerometer's bias, row-major, s."""


@looped
def measured(model, packed):
    """What `Sample.packed` holds."""
    n, wheels = len(model.columns.joints.parent), len(model.A_rw)
    k = 2 * n + 7 + wheels
    return Measured(
        packed[:n],
        packed[n : 2 * n],
        packed[2 * n : 2 * n + 3],
        packed[2 * n + 3 : 2 * n + 7],
        packed[2 * n + 7 : k],
        packed[k : k + 3],
        packed[k + 3 : k + 6],
        packed[k + 6 :],
    )


@looped
def complete(at):
    """Whether all is there but, perhaps, the velocity."""
    for part in (at.q, at.qd, at.w, at.x_WB, at.qd_rw, at.w_smooth):
        if not finite(part):
            return False
    return True


@looped
def rates_at(w, qd):
    """Of the base and of the joints."""
    rates = np.empty(3 + len(qd))
    for i in range(3):
        rates[i] = w[i]
    for k in range(len(qd)):
        rates[3 + k] = qd[k]
    return rates


@looped
def inertia_at(model, beta, q, bodies, H):
    """Place and weigh the bodies of `beta` at `q`, and fill `H` from `H+`."""
    theta = applied(model.theta_of, beta).reshape((len(bodies.m), PER_BODY))
    place(model.columns.joints, q, bodies)
    weigh(theta, bodies)
    mass_matrix(model.columns.joints, bodies, H)


@looped
def equations(model, noise, beta, h_cm, at, R_WB):
    """Both laws at one sample, whitened: `[H | rhs]`, momentum first.

    Args:
        model: of the robot.
        noise: of its sensors.
        beta: where `D`, `U` and the noise's gains are evaluated.
        h_cm: the momentum known so far, for the noise of the attitude.
        at: what was measured.
        R_WB: of the base, alone in its first axis.

    Returns:
        Of the unknowns `[h_cm, v_cm, b_g, b_a, pi, phi]`; zeros where `v_S` was not
        measured.
    """
    joints, n_h, n_v = len(at.q), len(model.turning), len(model.moving)
    bodies, H = room(joints + 1), np.zeros((6 + joints, 6 + joints))
    inertia_at(model, beta, at.q, bodies, H)
    D, U = _slopes(H, bodies)
    motion = np.empty((2, joints + 1, 3))
    # In the plane the other two rates stay what was measured: zero.
    rates, excess = rates_at(at.w, at.qd), np.zeros(3)
    for axis in model.turning:
        rates[axis] = at.w_smooth[axis]
        excess[axis] = at.w[axis] - at.w_smooth[axis]
    move(model.columns.joints, bodies, motion, rates)
    Y, W = regressors(model.columns, bodies, motion)
    pi = 2 * n_h + n_v + (n_v if noise.accelerometer else 0)
    rows = np.zeros((n_h + n_v, pi + Y.shape[1] + W.shape[1] + 1))
    h_rw = momentum_of_wheels(model, at)
    v_S = rotated_back(R_WB, 0, (at.v_S[0], at.v_S[1], at.v_S[2]))
    for i in range(n_h):
        axis = model.turning[i]
        put_rotation(R_WB, model.turning, axis, -1.0, rows[i], 0)
        _put_bias(model.turning, excess, -1.0, D[axis], rows[i], n_h + n_v)
        for k in range(Y.shape[1]):
            rows[i, pi + k] = Y[axis, k]
        rows[i, -1] -= h_rw[axis]
    for i in range(n_v if finite(at.v_S) else 0):
        axis, row = model.moving[i], rows[n_h + i]
        put_rotation(R_WB, model.moving, axis, 1.0, row, n_h)
        _put_bias(model.turning, excess, 1.0, U[axis], row, n_h + n_v)
        for k in range(W.shape[1]):
            row[pi + Y.shape[1] + k] = W[axis, k]
        row[-1] += v_S[axis]
    whiten(_of_momentum(model.turning, noise, H, D, h_cm, R_WB), rows[:n_h])
    whiten(_of_velocity(model, noise, bodies, U), rows[n_h:])
    return rows


@looped
def momentum_of_wheels(model, at):
    """`A_rw qd_rw`."""
    h = (0.0, 0.0, 0.0)
    for k in range(len(at.qd_rw)):
        h = plus(h, times(at.qd_rw[k], load(model.A_rw, k)))
    return h


@looped
def _slopes(H, bodies):
    """`D`, and `U = -[r_cm]x`."""
    D, U = np.empty((3, 3)), np.zeros((3, 3))
    for i in range(3):
        for j in range(i + 1):
            D[i, j] = D[j, i] = H[3 + i, 3 + j]
    x, y, z = times(1.0 / bodies.m[0], load(bodies.s, 0))
    U[0, 1], U[0, 2], U[1, 2] = z, -y, x
    U[1, 0], U[2, 0], U[2, 1] = -z, y, -x
    return D, U


@looped
def put_rotation(R_WB, axes, axis, sign, row, column):
    """A row of `R_0^T`."""
    for j in range(len(axes)):
        row[column + j] = sign * R_WB[0, axes[j], axis]


@looped
def _put_bias(axes, excess, sign, slope, row, column):
    """That of the gyro, and what takes the smoothed rate to its rate."""
    for j in range(len(axes)):
        row[column + j] = sign * slope[axes[j]]
        row[-1] += sign * slope[axes[j]] * excess[axes[j]]


# The covariance of either law's noise, from what each unit of noise does to it.


@looped
def _of_momentum(h, noise, H, D, h_cm, R_WB):
    joints = len(H) - 6
    C = np.zeros((len(h), len(h)))
    gains = np.empty(len(h))
    for k in h:
        for i in range(len(h)):
            gains[i] = noise.gyro * D[h[i], k]
        _add_square(C, gains)
    for k in range(joints):
        for i in range(len(h)):
            gains[i] = noise.joint_rates * H[6 + k, 3 + h[i]]
        _add_square(C, gains)
    for k in range(3):
        # A turn phi of the attitude turns R_0^T h_cm by R_0^T (h_cm x phi).
        for i in range(len(h)):
            column = R_WB[0, 0, h[i]], R_WB[0, 1, h[i]], R_WB[0, 2, h[i]]
            gains[i] = noise.attitude * cross(column, h_cm)[k]
        _add_square(C, gains)
    return C


@looped
def _of_velocity(model, noise, bodies, U):
    v = model.moving
    C = np.zeros((len(v), len(v)))
    gains = np.empty(len(v))
    for k in model.turning:
        for i in range(len(v)):
            gains[i] = noise.gyro * U[v[i], k]
        _add_square(C, gains)
    for k in range(len(bodies.p)):
        for i in range(len(v)):
            # J_cm = p / M.
            gains[i] = noise.joint_rates * bodies.p[k, v[i]] / bodies.m[0]
        _add_square(C, gains)
    for i in range(len(v)):
        C[i, i] += noise.velocity**2
    return C


@looped
def _add_square(C, gains):
    for i in range(len(gains)):
        for j in range(len(gains)):
            C[i, j] += gains[i] * gains[j]
