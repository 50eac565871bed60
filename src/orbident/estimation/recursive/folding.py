"""Householder reflections that take a few rows into a triangular factor."""

import numpy as np

from orbident.dynamics.loops.matrices import add_scaled, dot
from orbident.loops import looped

UNDERFLOW = 1e-200
"""Rounding leaves 1e-16 of rows that are used up, and 1e-16 of that, and so on."""


@looped
def fold(R, rows, first, count):
    """Rotate `rows` into `R`, both in place, until some of their columns are zero.

    Args:
        R: its first `count` columns are upper triangular, and stay so.
        rows: what is left of them keeps its directions.
        first: column of `rows` that goes with the first one of `R`.
        count: columns to be made zero.
    """
    w = np.empty(R.shape[1])
    for j in range(count):
        below = 0.0
        for i in range(len(rows)):
            below += rows[i, first + j] ** 2
        if below < UNDERFLOW:
            continue
        # (1 - beta u u^T) with u = [v, rows' column] takes that column to e_j.
        norm = np.sqrt(R[j, j] ** 2 + below)
        v = R[j, j] + (norm if R[j, j] >= 0.0 else -norm)
        beta = 2.0 / (v * v + below)
        # u^T of what is to be reflected, times beta.
        shares = w[j:]
        for c in range(len(shares)):
            shares[c] = 0.0
        add_scaled(beta * v, R[j, j:], shares)
        for i in range(len(rows)):
            add_scaled(beta * rows[i, first + j], rows[i, first + j :], shares)
        add_scaled(-v, shares, R[j, j:])
        for i in range(len(rows)):
            add_scaled(-rows[i, first + j], shares, rows[i, first + j :])
            rows[i, first + j] = 0.0


@looped
def fold_columns(R, columns):
    """The same for as many rows as `columns` are long, all columns but the last.

    Faster than `fold` where there are more rows than columns.
    """
    for j in range(len(R)):
        own = columns[j]
        below = dot(own, own)
        if below < UNDERFLOW:
            continue
        norm = np.sqrt(R[j, j] ** 2 + below)
        v = R[j, j] + (norm if R[j, j] >= 0.0 else -norm)
        beta = 2.0 / (v * v + below)
        for c in range(len(columns) - 1, j - 1, -1):
            share = beta * (v * R[j, c] + dot(own, columns[c]))
            R[j, c] -= v * share
            add_scaled(-share, own, columns[c])


@looped
def solved(R_z):
    """`x` of `R x = z`, from `[R | z]`."""
    n = len(R_z)
    x = np.empty(n)
    for i in range(n - 1, -1, -1):
        rest = R_z[i, n]
        for j in range(i + 1, n):
            rest -= R_z[i, j] * x[j]
        x[i] = rest / R_z[i, i]
    return x
