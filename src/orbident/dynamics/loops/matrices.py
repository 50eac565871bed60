"""Products of small matrices, written out: Numba compiles its own in seconds."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from orbident.loops import looped


class Sparse(NamedTuple):
    """A matrix that is mostly zero."""

    row: Int[np.ndarray, " entries"]
    column: Int[np.ndarray, " entries"]
    value: Float[np.ndarray, " entries"]
    columns: int


def sparse_of(A: Float[np.ndarray, "m n"]) -> Sparse:
    """The entries of a matrix that are not zero."""
    row, column = np.nonzero(A)
    return Sparse(row, column, A[row, column], A.shape[1])


@looped
def add_scaled(k, x, y):
    """`y += k x`, of as many entries as `y` has."""
    for i in range(len(y)):
        y[i] += k * x[i]


@looped
def dot(x, y):
    """`x . y`, of as many entries as `x` has."""
    total = 0.0
    for i in range(len(x)):
        total += x[i] * y[i]
    return total


@looped
def product(A, B):
    """`A B`, of a sparse `B`."""
    C = np.zeros((A.shape[0], B.columns))
    for k in range(len(B.value)):
        for i in range(A.shape[0]):
            C[i, B.column[k]] += A[i, B.row[k]] * B.value[k]
    return C


@looped
def applied(A, x):
    """`A x`, of as many columns as `x` has entries."""
    y = np.empty(len(A))
    for i in range(len(A)):
        y[i] = dot(x, A[i])
    return y


@looped
def assign(x, y):
    """`x = y`, of as many entries as `x` has."""
    for i in range(len(x)):
        x[i] = y[i]


@looped
def finite(x):
    """Whether all of a vector is."""
    # inf - inf is not a number either.
    rest = 0.0
    for k in range(len(x)):
        rest += x[k] - x[k]
    return rest == 0.0


@looped
def whiten(C, rows):
    """`L^-1 rows` in place, with `L L^T = C`."""
    L = np.zeros(C.shape)
    for i in range(len(C)):
        for j in range(i):
            L[i, j] = (C[i, j] - dot(L[i, :j], L[j])) / L[j, j]
            add_scaled(-L[i, j], rows[j], rows[i])
        L[i, i] = np.sqrt(C[i, i] - dot(L[i, :i], L[i]))
        for c in range(rows.shape[1]):
            rows[i, c] /= L[i, i]
