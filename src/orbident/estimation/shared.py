"""What recordings of one robot have in common, and what each says of it, as data.

Base parameters and the errors of instruments are the same in all recordings; momentum,
attitudes, biases and what acts from outside are each one's own. A recording's equations
without its own unknowns, `R x = z` of `x = [beta | errors]`, are all that another one
needs: with them beside its own it is fitted as if both were fitted at once.
"""

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
        return triangular(np.vstack([known, rows]))[m : rows.shape[1] - 1, m:]


def together(parts: Sequence[Shared]) -> Shared:
    """What several recordings say.

    Args:
        parts: what each of them says; the last was linearised nearest to the truth.
    """
    errors = {each.name: each for part in parts for each in part.errors}
    every = tuple(errors.values())
    rows = np.vstack([part.over(every) for part in parts])
    return Shared(parts[-1].beta, every, triangular(rows)[: rows.shape[1] - 1])


def triangular(rows: Float[np.ndarray, "rows n"]) -> Float[np.ndarray, "_ n"]:
    """The triangular factor of these rows."""
    return np.asarray(np.linalg.qr(rows, mode="r"))
