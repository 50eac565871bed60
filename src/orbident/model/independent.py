"""Which columns of a matrix are independent, and how they make up the others."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.linalg import solve_triangular

# Over random samples the distance of an independent column from the span of those
# before it is 1e-3 to 1 of its norm, of a dependent one 1e-14 (14 joints): the
# threshold lies in the middle of that gap.
DEPENDENT = 1e-8

BLOCK = 64
"""Columns from which the part that is known is taken at once: a product of matrices."""


class Independent(NamedTuple):
    """`X = X[:, columns] T`."""

    columns: list[int]
    T: Float[np.ndarray, "independent all"]


def independent_columns(X: Float[np.ndarray, "rows all"]) -> Independent:
    """The first columns, from the left, that span all of `X`.

    First come, first kept: so the order of the columns decides which parameters
    stand for the others, as in the classical regrouping (Khalil and Dombre, 2002).
    Gram-Schmidt with a second pass, which makes it orthogonal to rounding.
    """
    if len(X) > X.shape[1]:
        # The triangular factor has the same dependencies, and fewer rows.
        X = np.asarray(np.linalg.qr(X, mode="r"))
    norms = np.linalg.norm(X, axis=0)
    shown = norms > DEPENDENT * norms.max(initial=0.0)
    size = np.where(shown, norms, 1.0)
    unit = np.where(shown, X / size, 0.0)
    basis, columns = _orthonormal(unit)
    T = solve_triangular(basis.T @ unit[:, columns], basis.T) @ unit
    T[:, columns] = np.eye(len(columns))
    return Independent(columns, T * size / size[columns, None])


def _orthonormal(
    X: Float[np.ndarray, "rows all"],
) -> tuple[Float[np.ndarray, "rows independent"], list[int]]:
    """A basis of the columns' span, and the columns that each added to it."""
    Q = np.empty((len(X), min(X.shape)), order="F")
    columns: list[int] = []
    for start in range(0, X.shape[1], BLOCK):
        V = _apart(X[:, start : start + BLOCK], Q[:, : len(columns)])
        for k in np.flatnonzero(np.linalg.norm(V, axis=0) > DEPENDENT):
            if len(columns) == Q.shape[1]:
                return Q, columns
            basis = Q[:, : len(columns)]
            v = _apart(_apart(V[:, k], basis), basis)
            distance = np.linalg.norm(v)
            if distance > DEPENDENT:
                Q[:, len(columns)] = v / distance
                columns.append(start + int(k))
    return Q[:, : len(columns)], columns


def _apart(V: np.ndarray, basis: Float[np.ndarray, "rows n"]) -> np.ndarray:
    """What of one or many vectors is not in the span of the basis."""
    return V - basis @ (basis.T @ V)
