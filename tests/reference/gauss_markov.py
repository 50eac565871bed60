"""A slow, obvious smoother: all states of a Gauss-Markov process at once."""

from math import factorial

import numpy as np


class GaussMarkov:
    """`s_k+1 = F_k s_k + N(0, Q_k)`, `y_k = H s_k + N(0, R)`, by least squares.

    Every equation is divided by its standard deviation; `y` is NaN on rows without a
    sample, and `before` is the covariance of the first state, None where nothing is
    known of it.
    """

    def __init__(self, F, Q, H, y, R, before=None):
        n, size = len(y), H.shape[1]
        rows, right = [], []

        def add(covariance, blocks, values):
            whitening = np.linalg.inv(np.linalg.cholesky(covariance))
            row = np.zeros((len(values), n, size))
            for k, block in blocks.items():
                row[:, k] = block
            rows.append(whitening @ row.reshape(len(values), -1))
            right.append(whitening @ values)

        if before is not None:
            add(before, {0: np.eye(size)}, np.zeros(size))
        for k in range(n - 1):
            add(Q[k], {k + 1: np.eye(size), k: -F[k]}, np.zeros(size))
        for k in np.flatnonzero(np.isfinite(y).all(axis=1)):
            add(R * np.eye(len(H)), {k: H}, y[k])
        q, r = np.linalg.qr(np.vstack(rows))
        inverse = np.linalg.inv(r)
        self.mean = (inverse @ (q.T @ np.concatenate(right))).reshape(n, size)
        covariance = (inverse @ inverse.T).reshape(n, size, n, size)
        self.covariance = np.array([covariance[k, :, k] for k in range(n)])


def white_snap(dt, density):
    """`F` and `Q` of a position whose snap is white, of every step.

    `F_ij = dt^(j-i) / (j-i)!`, `Q_ij = density int_0^dt u^(p+q) / (p! q!) du`, with
    `p = 3 - i` and `q = 3 - j`.
    """
    F, Q = np.zeros((2, dt.size, 4, 4))
    for i in range(4):
        for j in range(4):
            p, q = 3 - i, 3 - j
            Q[:, i, j] = dt ** (p + q + 1) / (p + q + 1) / factorial(p) / factorial(q)
            if j >= i:
                F[:, i, j] = dt ** (j - i) / factorial(j - i)
    return F, density * Q
