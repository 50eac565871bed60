"""Products of small matrices, written out: Numba compiles its own in seconds."""

import numpy as np

from orbident.loops import looped


@looped
def add_scaled(k, x, y):
    """`y += k x`, of as many entries as `y` has."""
    for i in range(len(y)):
        y[i] += k * x[i]


@looped
def product(A, B):
    """`A B`."""
    C = np.zeros((A.shape[0], B.shape[1]))
    for i in range(A.shape[0]):
        for k in range(A.shape[1]):
            add_scaled(A[i, k], B[k], C[i])
    return C


@looped
def applied(A, x):
    """`A x`, of as many columns as `x` has entries."""
    y = np.zeros(A.shape[0])
    for i in range(A.shape[0]):
        for k in range(len(x)):
            y[i] += A[i, k] * x[k]
    return y


@looped
def left(A, n):
    """The first `n` columns, copied."""
    B = np.empty((A.shape[0], n))
    for i in range(A.shape[0]):
        for j in range(n):
            B[i, j] = A[i, j]
    return B


@looped
def finite(x):
    """Whether all of a vector is."""
    # inf - inf is not a number either.
    rest = 0.0
    for k in range(len(x)):
        rest += x[k] - x[k]
    return rest == 0.0
