"""How a base stood at first that nobody saw, by the velocity of S in inertial axes.

A gyro shows how a base turned since its first sample, `R(t)`. With `R_0` its attitude
then, Eq. 31 is, up to the constant velocity of the CM,

    v_S(t) = R_0 R(t) W phi

which is linear in `phi`, and of `R_0` is Wahba's problem (Kabsch 1976). Each is solved
with the other known, in turn, from nominal `phi` on. In the plane turns commute, and
another `R_0` is another `phi`: there inertial axes are those of the base at first.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from orbident.model.minimal_sets import minimal_sets
from orbident.preprocessing.histories import Columns
from orbident.robot.description import Robot

ROWS = 500
"""So many rows, evenly spaced, show three angles as well as all do."""

ROUNDS = 100
"""Rounds that are made at most: a dozen are usual."""

SETTLED = 1e-6
"""rad: an attitude that changes by less from round to round has settled."""

UNTURNED = 1e-3
"""Over all velocities: what an attitude of zero weighs, where they show none."""


def with_first_attitude(
    robot: Robot, q: Columns, qd: Columns, w: Columns, x_WB: Columns, v_S: Columns
) -> Columns:
    """The attitude at all rows, in the axes of the velocity.

    Args:
        robot: with its nominal inertia.
        q: rad or m.
        qd: rad/s or m/s.
        w: base axes, rad/s.
        x_WB: from an attitude of zero on.
        v_S: inertial axes, m/s.
    """
    every = np.column_stack([*q, *qd, *w, *x_WB, *v_S])
    rows = np.flatnonzero(np.isfinite(every).all(axis=1))
    if not rows.size:
        return x_WB
    rows = rows[:: max(rows.size // ROWS, 1)]
    ends = np.cumsum([len(q), len(qd), len(w), len(x_WB)])
    q_, qd_, w_, x_, v = np.split(every[rows], ends, axis=1)
    sets = minimal_sets(robot)
    _, W = sets.regressors(*map(np.ascontiguousarray, (q_, qd_, w_)))
    W = Rotation.from_quat(x_).as_matrix() @ W
    W, v = W - W.mean(axis=0), v - v.mean(axis=0)
    size = np.linalg.norm(v)
    if not 0 < size < np.inf:
        return x_WB
    phi, first = sets.phi(robot.theta), Rotation.identity()
    none = UNTURNED * size * np.eye(3)
    for _ in range(ROUNDS):
        before = first
        shown, predicted = np.vstack([v, none]), np.vstack([W @ phi, none])
        first = Rotation.align_vectors(shown, predicted)[0]
        left = first.inv().apply(v) - W @ phi
        phi = phi + np.linalg.lstsq(W.reshape(-1, phi.size), left.ravel())[0]
        if (first * before.inv()).magnitude() < SETTLED:
            break
    known = np.isfinite(np.column_stack(x_WB)).all(axis=1)
    x = np.column_stack(x_WB)
    x[known] = (first * Rotation.from_quat(x[known])).as_quat()
    return tuple(x.T)
