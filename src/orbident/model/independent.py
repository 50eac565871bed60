"""Which columns of a matrix are independent, and how they make up the others."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

# Over random samples the distance of an independent column from the span of those
# before it is 1e-3 to 1 of its norm, of a dependent one 1e-14 (14 joints): the
# threshold lies in the middle of that gap.
DEPENDENT = 1e-8


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
    # The triangular factor has the same dependencies, and fewer rows.
    X = np.asarray(np.linalg.qr(X, mode="r"))
    norms = np.linalg.norm(X, axis=0)
    largest = norms.max(initial=0.0)
    Q = np.empty((X.shape[0], min(X.shape)))
    columns: list[int] = []
    for k, norm in enumerate(norms):
        if len(columns) == Q.shape[1]:
            break
        if norm <= DEPENDENT * largest:
            continue
        v = X[:, k] / norm
        basis = Q[:, : len(columns)]
        for _ in range(2):
            v = v - basis @ (basis.T @ v)
        distance = np.linalg.norm(v)
        if distance > DEPENDENT:
            Q[:, len(columns)] = v / distance
            columns.append(k)
    basis = Q[:, : len(columns)]
    seen = np.where(norms > DEPENDENT * largest, norms, 1.0)
    unit = X / seen * (norms > DEPENDENT * largest)
    T = np.linalg.solve(basis.T @ unit[:, columns], basis.T @ unit)
    T[:, columns] = np.eye(len(columns))
    return Independent(columns, T * seen / seen[columns, None])
