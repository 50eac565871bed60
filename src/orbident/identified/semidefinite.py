"""The nearest positive definite matrices under linear equations; cvxpy's one user."""

import warnings
from types import ModuleType
from typing import Any

import numpy as np
from jaxtyping import Float

from orbident.extras import extra

SMALLEST = 1e-3
"""The least eigenvalue of a matrix that could not stay near 1."""
ROOM = 1.05
"""So much further from the equations than need be may the nearest matrices lie."""
TOLERANCE = 1e-10


def nearest_to_one(
    A: Float[np.ndarray, "equations entries"],
    b: Float[np.ndarray, " equations"],
) -> Float[np.ndarray, "n 4 4"] | None:
    """Symmetric `X_i > 0` with `A vec(X) = b`, least `sum tr X_i - log det X_i`.

    Args:
        A: over all entries of all matrices, row after row.
        b: right-hand side.

    Returns:
        The matrices; None where there are none.

    Raises:
        MissingLibraryError: cvxpy is not installed.
    """
    cp = _cvxpy()
    X = _matrices(cp, A)
    return _solved(cp, X, _divergence(cp, X), [A @ _entries(cp, X) == b])


def nearest_within(
    A: Float[np.ndarray, "equations entries"],
    b: Float[np.ndarray, " equations"],
    root: Float[np.ndarray, "equations r"],
    most: float,
) -> tuple[Float[np.ndarray, "n 4 4"], float] | None:
    """The same with `A vec(X) = b + root z`, where `|z|` is hardly more than it must.

    Args:
        A: over all entries of all matrices, row after row.
        b: right-hand side.
        root: a square root of the covariance of `b`.
        most: so long `z` may be.

    Returns:
        The matrices and `|z|`; None where there are none with so short a `z`.

    Raises:
        MissingLibraryError: cvxpy is not installed.
    """
    cp = _cvxpy()
    X, z = _matrices(cp, A), cp.Variable(root.shape[1])
    off = cp.norm(z)
    equations = [A @ _entries(cp, X) == b + root @ z]
    bounded = [*equations, *(each >> SMALLEST * np.eye(4) for each in X)]
    if _solved(cp, X, off, bounded) is None or off.value > most:
        return None
    within = [*equations, off <= ROOM * float(off.value)]
    found = _solved(cp, X, _divergence(cp, X), within)
    return None if found is None else (found, float(off.value))


def _matrices(cp: ModuleType, A: Float[np.ndarray, "equations entries"]) -> list[Any]:
    return [cp.Variable((4, 4), symmetric=True) for _ in range(A.shape[1] // 16)]


def _entries(cp: ModuleType, X: list[Any]) -> Any:
    return cp.hstack([cp.vec(each, order="C") for each in X])


def _divergence(cp: ModuleType, X: list[Any]) -> Any:
    return cp.sum([cp.trace(each) - cp.log_det(each) for each in X])


def _solved(
    cp: ModuleType, X: list[Any], cost: Any, constraints: list[Any]
) -> Float[np.ndarray, "n 4 4"] | None:
    problem = cp.Problem(cp.Minimize(cost), constraints)
    tolerances = dict.fromkeys(("tol_feas", "tol_gap_abs", "tol_gap_rel"), TOLERANCE)
    with warnings.catch_warnings():
        # Of a solution that is a little less accurate; the caller checks it.
        warnings.simplefilter("ignore")
        try:
            problem.solve(solver=cp.CLARABEL, **tolerances)
        except cp.SolverError:
            return None
    if problem.status not in {cp.OPTIMAL, cp.OPTIMAL_INACCURATE}:
        return None
    return np.array([each.value for each in X])


def _cvxpy() -> ModuleType:
    # Late: the import takes more than a second.
    with extra("export", "the search for physically possible bodies"):
        import cvxpy

    return cvxpy
