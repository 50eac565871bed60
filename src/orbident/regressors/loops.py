"""`Y` (Eq. 19) and `W` (Eq. 29) of one sample, in compiled loops.

The formulas are those of `regressors.momentum` and `regressors.minimal_sets`.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Int

from orbident.dynamics.loops.bodies import Joints, joints_of
from orbident.dynamics.loops.matrices import Sparse, product, sparse_of
from orbident.dynamics.loops.vectors import cross, load, plus, rotated_back, times
from orbident.loops import looped
from orbident.regressors.minimal_sets import Regressors
from orbident.robot.parameters import PER_BODY


class Columns(NamedTuple):
    """What `Y` and `W` need of a robot."""

    joints: Joints
    theta_of_linear: Sparse
    theta_of_sigma: Sparse
    first: Int[np.ndarray, " products"]
    second: Int[np.ndarray, " products"]


def columns_of(regressors: Regressors) -> Columns:
    """A robot's regressors, as the loops take them."""
    return Columns(
        joints_of(regressors.tree),
        sparse_of(np.asarray(regressors.theta_of_linear)),
        sparse_of(np.asarray(regressors.theta_of_sigma)),
        np.ascontiguousarray(regressors.first),
        np.ascontiguousarray(regressors.second),
    )


@looped
def regressors(columns, bodies, motion):
    """`Y` and `W` of all three axes, at placed bodies in motion; base axes."""
    S, P, A = momentum(bodies, motion)
    S_sigma = product(S, columns.theta_of_sigma)
    P_sigma = product(P, columns.theta_of_sigma)
    linear = product(A, columns.theta_of_linear)
    own = linear.shape[1]
    Y = np.empty((3, own + len(columns.first)))
    for i in range(3):
        for k in range(own):
            Y[i, k] = linear[i, k]
    for k in range(len(columns.first)):
        a, b = columns.first[k], columns.second[k]
        S_a = S_sigma[0, a], S_sigma[1, a], S_sigma[2, a]
        S_b = S_sigma[0, b], S_sigma[1, b], S_sigma[2, b]
        P_a = P_sigma[0, a], P_sigma[1, a], P_sigma[2, a]
        P_b = P_sigma[0, b], P_sigma[1, b], P_sigma[2, b]
        both = plus(cross(S_a, P_b), cross(S_b, P_a))
        _fill(Y, own + k, times(-0.5 if a == b else -1.0, both))
    for i in range(3):
        for k in range(P_sigma.shape[1]):
            P_sigma[i, k] = -P_sigma[i, k]
    return Y, P_sigma


@looped
def momentum(bodies, motion):
    """`S`, `P` and `A`; columns are the flat `theta`, base first."""
    count = len(bodies.m)
    S = np.zeros((3, PER_BODY * count))
    P, A = np.zeros(S.shape), np.zeros(S.shape)
    for i in range(count):
        k, R, d, w = PER_BODY * i, bodies.R, load(bodies.d, i), load(motion[0], i)
        v = plus(load(motion[1], i), cross(w, d))
        _fill(S, k, d)
        _fill(P, k, v)
        _fill(A, k, cross(d, v))
        for j in range(3):
            r = R[i, 0, j], R[i, 1, j], R[i, 2, j]
            turning = cross(w, r)
            _fill(S, k + 1 + j, r)
            _fill(P, k + 1 + j, turning)
            _fill(A, k + 1 + j, plus(cross(d, turning), cross(r, v)))
        # R L(R^T w), with J w = L(w) [Jxx, Jxy, Jyy, Jxz, Jyz, Jzz].
        x, y, z = rotated_back(R, i, w)
        for j in range(3):
            A[j, k + 4] = R[i, j, 0] * x
            A[j, k + 5] = R[i, j, 0] * y + R[i, j, 1] * x
            A[j, k + 6] = R[i, j, 1] * y
            A[j, k + 7] = R[i, j, 0] * z + R[i, j, 2] * x
            A[j, k + 8] = R[i, j, 1] * z + R[i, j, 2] * y
            A[j, k + 9] = R[i, j, 2] * z
    return S, P, A


@looped
def _fill(X, k, column):
    X[0, k], X[1, k], X[2, k] = column
