"""Elimination along the chain, against one dense least-squares problem."""

from functools import partial

import numpy as np
import pytest

from orbident.estimation.output_error.sweep import swept

Z, G = 4, 3
"""Unknowns of a boundary, and those that all have in common."""


class Chain:
    """Random equations of `[z_s, z_{s+1}, g, rhs]`, segment after segment."""

    def __init__(self, seed: int, segments: int, rows: int = 9):
        random = np.random.default_rng(seed)
        self.before = np.triu(random.standard_normal((Z + G + 1,) * 2))
        self.parts = random.standard_normal((segments, rows, 2 * Z + G + 1))

    def dense(self) -> tuple[np.ndarray, np.ndarray]:
        """All equations over `[z_0 ... z_S, g]`, and their right-hand side."""
        segments, rows, _ = self.parts.shape
        chain = Z * (segments + 1)
        table = np.zeros((len(self.before) + segments * rows, chain + G + 1))
        table[: len(self.before), np.r_[:Z, chain : chain + G + 1]] = self.before
        for s, part in enumerate(self.parts):
            row = len(self.before) + s * rows
            place = np.r_[Z * s : Z * (s + 2), chain : chain + G + 1]
            table[row : row + rows, place] = part
        return table[:, :-1], table[:, -1]


# Rounding of some hundred rotations, times the condition of a random matrix.
close = partial(np.testing.assert_allclose, rtol=1e-9, atol=1e-10)


@pytest.mark.parametrize("segments", [1, 2, 7])
def test_the_chain_gives_what_the_dense_problem_gives(segments):
    chain = Chain(segments, segments)
    A, b = chain.dense()
    x, *_ = np.linalg.lstsq(A, b)
    z, g = x[:-G].reshape(-1, Z), x[-G:]
    known = swept(chain.before, chain.parts, Z)
    assert len(known.links) == segments
    found = np.linalg.solve(known.common[:G, :G], known.common[:G, -1])
    close(found, g)
    close(known.chained(found), z)
    # What is left of the right-hand side is the residual.
    left = np.linalg.norm(b - A @ x)
    np.testing.assert_allclose(abs(known.factor[-1, -1]), left, rtol=1e-9)


def test_what_is_known_at_the_end_is_the_information():
    chain = Chain(0, 5)
    A, _ = chain.dense()
    covariance = np.linalg.inv(A.T @ A)[-Z - G :, -Z - G :]
    factor = swept(chain.before, chain.parts, Z).factor[:-1, :-1]
    close(np.linalg.inv(factor.T @ factor), covariance)


def test_boundaries_for_any_common_unknowns():
    """The least-squares `z` where `g` is given."""
    chain = Chain(1, 4)
    A, b = chain.dense()
    g = np.array([3.0, -2.0, 1.0])
    expected, *_ = np.linalg.lstsq(A[:, :-G], b - A[:, -G:] @ g)
    found = swept(chain.before, chain.parts, Z).chained(g)
    close(found.ravel(), expected)


def test_segments_without_equations_of_their_own_change_nothing():
    """Fillers only say that a boundary is where the last one was."""
    chain = Chain(2, 3)
    filler = np.zeros((Z, 2 * Z + G + 1))
    filler[:, :Z], filler[:, Z : 2 * Z] = np.eye(Z), -np.eye(Z)
    plain = swept(chain.before, chain.parts, Z)
    longer = swept(chain.before, [*chain.parts, 1e5 * filler], Z)
    g = np.linalg.solve(plain.common[:G, :G], plain.common[:G, -1])
    z = longer.chained(g)
    # Fillers weigh 1e5 times as much as all else, and so does their rounding.
    close(z[:-1], plain.chained(g))
    close(z[-1], z[-2])
