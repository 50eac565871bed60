"""Least squares through a triangular factor that takes rows in as they come.

`R` is the triangular factor of all rows seen so far: memory does not grow with their
number, and nothing is ever squared.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.linalg import get_lapack_funcs

from orbident.errors import InputError

# Singular values of the factor with unit columns: what the motion never shows comes
# out at 1e-16 to 1e-14, and what it does show is worth reporting with its error.
RANK = 1e-12
# A parameter with this much of the unseen directions in it is not determined.
UNDETERMINED = 1e-6
# Of the right-hand side: what rounding of some thousand rows adds to a solution.
ROUNDING = 1e-13
# Columns that LAPACK factors at once: 16 to 32 are equally fast up to 500 columns.
BLOCK = 16

(_tpqrt,) = get_lapack_funcs(("tpqrt",), dtype=np.float64)


def fold(
    R: Float[np.ndarray, "n n"], rows: Float[np.ndarray, "rows n"]
) -> Float[np.ndarray, "n n"]:
    """The triangular factor with some more rows.

    LAPACK's tpqrt leaves alone the zeros that `R` already has: half the time of a QR
    of the two stacked.
    """
    factor, _, _, _ = _tpqrt(0, min(BLOCK, len(R)), R, rows)
    return factor


def triangular_factor(rows: Float[np.ndarray, "rows n"]) -> Float[np.ndarray, "_ n"]:
    """The triangular factor of some rows: `R^T R = rows^T rows`."""
    return np.asarray(np.linalg.qr(rows, mode="r"))


class LinearFit(NamedTuple):
    """A linear least-squares estimate, and what the rows could not tell."""

    values: Float[np.ndarray, " n"]
    """The shortest solution; meaningless where not `determined`."""
    covariance: Float[np.ndarray, "n n"]
    determined: Bool[np.ndarray, " n"]
    hidden: Float[np.ndarray, "n hidden"]
    """Columns: changes of the parameters that no row shows."""
    factor: Float[np.ndarray, "n n"]
    """Triangular, of the parameters' columns with the nuisance projected out."""
    target: Float[np.ndarray, " n"]
    """The right-hand side that goes with it."""
    nuisances: Float[np.ndarray, " m"]
    """The unknowns that are no parameters."""
    nuisances_std: Float[np.ndarray, " m"]
    rms: float
    """The root mean square of the residual, per row not needed to fix an unknown."""
    explained: float
    """Norm of what the parameters explain of it, nuisance apart."""
    unexplained: float
    """Norm of the residual."""
    unexplained_freed: float
    """Norm of the residual if the checked columns were unknowns too."""
    explained_freed: float
    """Norm of what the parameters would explain then, beside those columns."""
    freed: Float[np.ndarray, " checked"]
    """The unknowns of the checked columns then."""

    @property
    def scatter(self) -> float:
        """Std of a row: that of the residual, or what rounding makes of exact data."""
        return _scatter(self.rms, self.target)


def _scatter(rms: float, target: Float[np.ndarray, " n"]) -> float:
    return max(rms, ROUNDING * float(np.linalg.norm(target)))


class Layout(NamedTuple):
    """What the columns are, from the left; the right-hand side is the last."""

    nuisances: int
    """Unknowns that are estimated but not reported."""
    parameters: int
    checked: int
    """What was assumed to be known: columns of unknowns that should not be needed."""

    @property
    def columns(self) -> int:
        """How many columns there are, with the right-hand side."""
        return sum(self) + 1


def solve_factor(
    R: Float[np.ndarray, "all all"], layout: Layout, rows: int
) -> LinearFit:
    """Solve for all unknowns from the triangular factor.

    Args:
        R: of `[nuisance | parameters | checked | right-hand side]`.
        layout: how many columns are which.
        rows: how many rows went in.
    """
    unknowns = layout.nuisances + layout.parameters
    columns, z = R[:unknowns, :unknowns], R[:unknowns, -1]
    unexplained = float(np.linalg.norm(R[unknowns:, -1]))
    norms = np.linalg.norm(columns, axis=0)
    norms = np.where(norms > 0.0, norms, 1.0)
    U, s, Vt = np.linalg.svd(columns / norms)
    seen = s > RANK * s.max(initial=0.0)
    inverse = np.where(seen, 1 / np.where(seen, s, 1.0), 0.0)
    root = Vt.T * inverse / norms[:, None]
    solution = root @ (U.T @ z)
    other, own = np.s_[: layout.nuisances], np.s_[layout.nuisances :]
    hidden = Vt[~seen][:, own].T
    rms = unexplained / np.sqrt(max(rows - int(seen.sum()), 1))
    covariance = _scatter(rms, z[own]) ** 2 * root @ root.T
    return LinearFit(
        values=solution[own],
        covariance=covariance[own, own],
        determined=np.linalg.norm(hidden, axis=1) <= UNDETERMINED,
        hidden=hidden / norms[own, None],
        factor=columns[own, own],
        target=z[own],
        nuisances=solution[other],
        nuisances_std=np.sqrt(np.diag(covariance)[other]),
        rms=rms,
        explained=float(np.linalg.norm(z[own])),
        unexplained=unexplained,
        unexplained_freed=abs(float(R[-1, -1])),
        explained_freed=_explained_freed(R, layout),
        freed=np.linalg.lstsq(R[unknowns:-1, unknowns:-1], R[unknowns:-1, -1])[0],
    )


def _explained_freed(R: Float[np.ndarray, "all all"], layout: Layout) -> float:
    """Norm of what the checked columns, put in front, leave for the parameters."""
    own = np.arange(layout.nuisances, layout.nuisances + layout.parameters)
    rest = np.setdiff1d(np.arange(layout.columns), own)
    order = [*rest[:-1], *own, rest[-1]]
    z = triangular_factor(R[:, order])[:, -1]
    return float(np.linalg.norm(z[len(rest) - 1 : -1]))


def condition_numbers(factor: Float[np.ndarray, "n n"]) -> tuple[float, float]:
    """The condition of the columns as they are, and scaled to unit norm."""
    if factor.size == 0:
        return 1.0, 1.0
    norms = np.linalg.norm(factor, axis=0)
    if not norms.all():
        return float("inf"), float("inf")
    return float(np.linalg.cond(factor)), float(np.linalg.cond(factor / norms))


def check_finite(*numbers: np.ndarray | float) -> None:
    """Refuse equations that are not finite.

    Raises:
        InputError: a number is infinite or none.
    """
    if not all(np.isfinite(each).all() for each in numbers):
        raise InputError(
            "what the sensors should show overflows, so nothing can be fitted to it; "
            "check the units of the recording (s, rad, rad/s, m) and of the robot's "
            "masses and inertias (kg, kg m^2)"
        )
