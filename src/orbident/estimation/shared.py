"""What recordings of one robot share, as data: equations without their own unknowns."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.estimation.unknowns import Unknown


class Shared(NamedTuple):
    """Whitened equations of `beta` and of errors of instruments, to first order."""

    beta: Float[np.ndarray, " beta"]
    """Near where they were linearised."""
    errors: tuple[Unknown, ...]
    """Those that have a tolerance, which is not among the equations."""
    equations: Float[np.ndarray, "rows columns"]
    """`[R, z]` over `[beta | errors]`."""

    def over(self, errors: Sequence[Unknown]) -> Float[np.ndarray, "rows columns"]:
        """The equations over `beta` and these errors; all others are eliminated."""
        wanted = {each.name for each in errors}
        more = [each for each in self.errors if each.name not in wanted]
        n, m = self.beta.size, len(more)
        of_error = {
            each.name: column
            for each, column in zip(self.errors, self.equations[:, n:-1].T, strict=True)
        }
        none = np.zeros(len(self.equations))
        rows = np.column_stack(
            [
                *(of_error[each.name] for each in more),
                self.equations[:, :n],
                *(of_error.get(each.name, none) for each in errors),
                self.equations[:, -1],
            ]
        )
        known = np.zeros((m, rows.shape[1]))
        np.fill_diagonal(known, [1 / each.std for each in more])
        return _triangular(np.vstack([known, rows]))[m : rows.shape[1] - 1, m:]


def _triangular(rows: Float[np.ndarray, "rows n"]) -> Float[np.ndarray, "_ n"]:
    return np.asarray(np.linalg.qr(rows, mode="r"))
