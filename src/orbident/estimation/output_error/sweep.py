"""Least squares over a chain of segments, in square-root information form.

Each segment's equations hold its own unknowns `z_s`, the next segment's and those that
all have in common, `g`. A QR factorisation of

    [ known so far | equations of segment s ]   over   [z_s  z_{s+1}  g | rhs]

leaves the rows that give `z_s` once the others are known, and below them all that is
known of `z_{s+1}` and `g` (Bierman, 1977). Time is linear in the number of segments.
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.linalg import solve_triangular

from orbident.estimation.triangular import fold


class Known(NamedTuple):
    """What the equations tell: `factor [z_last; g] = rhs`, and how to go back."""

    factor: Float[np.ndarray, "n n"]
    """Triangular, over `[z_last, g, rhs]`."""
    links: tuple[Float[np.ndarray, "z columns"], ...]
    """Of each segment: rows over `[z_s, z_{s+1}, g, rhs]`."""
    chain: int
    """Size of `z`."""

    @property
    def common(self) -> Float[np.ndarray, "n n"]:
        """The part over `[g, rhs]`."""
        return self.factor[self.chain :, self.chain :]

    def chained(self, g: Float[np.ndarray, " g"]) -> Float[np.ndarray, "boundaries z"]:
        """`z_s` of each segment and of the end, for any `g`."""
        n = self.chain
        top = self.factor[:n]
        z = [solve_triangular(top[:, :n], top[:, -1] - top[:, n:-1] @ g)]
        for link in reversed(self.links):
            after = link[:, n : 2 * n] @ z[-1] + link[:, 2 * n : -1] @ g
            z.append(solve_triangular(link[:, :n], link[:, -1] - after))
        return np.array(z[::-1])


def swept(
    before: Float[np.ndarray, "n n"],
    segments: Iterable[Float[np.ndarray, "_ columns"]],
    chain: int,
) -> Known:
    """Eliminate segment after segment.

    Args:
        before: triangular, what is known of `[z_0, g]` beforehand.
        segments: their equations over `[z_s, z_{s+1}, g, rhs]`.
        chain: size of `z`.
    """
    links, known = [], before
    old = np.r_[:chain, 2 * chain : before.shape[1] + chain]
    for rows in segments:
        everything = np.zeros((rows.shape[1],) * 2)
        everything[np.ix_(old, old)] = known
        factor = fold(everything, rows)
        links.append(factor[:chain].copy())
        known = factor[chain:, chain:]
    return Known(known, tuple(links), chain)
