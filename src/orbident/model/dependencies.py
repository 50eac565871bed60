"""Which columns of `h_rs` depend on each other, joint by joint from the tips.

`h_rs` has a column for every free-flying base parameter and for every product of two
first moments `sigma_a sigma_b / M`. There are as many products as the joints' number
squared, so that no matrix of all of them over random motion is ever made. Instead:

- a column belongs to the last body whose parameters are in it;
- among the columns of the bodies up to body `k` only those that belong to it depend on
  the rate of its joint, for joints are in topological order;
- so what makes zero of all columns makes zero, in the part that is linear in that rate,
  of that body's columns alone. What does is kept, and must make zero in the bodies
  before it too, by their rates, and at last by the rate of the base.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int
from scipy.linalg import solve_triangular
from scipy.sparse import csc_array

from orbident.model.kinematics import momentum_regressors
from orbident.robot.description import Robot
from orbident.robot.parameters import PER_BODY

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


SPARE = 1.5
FEWEST = 30
"""So many times more equations than unknowns, and samples beside: random equations are
then well conditioned."""

ZERO = 1e-9
"""Parameters below this part of the largest of a column are rounding."""

ROUNDING = 1e-16
"""Rounding in a combination of length one. Without this, rounding of rounding of sixty
bodies ends in numbers near 1e-308, which processors are slow at."""


@dataclass(frozen=True)
class Columns:
    """The columns of `h_rs`: first those of `beta`, then those of the products."""

    robot: Robot
    theta_of: Float[np.ndarray, "theta beta"]
    sigma: slice
    pairs: Int[np.ndarray, "pairs 2"]
    axes: tuple[int, ...]

    @property
    def count(self) -> int:
        """How many columns there are."""
        return self.theta_of.shape[1] + len(self.pairs)

    def bodies(self) -> Int[np.ndarray, " columns"]:
        """The body that each column belongs to."""
        size = np.abs(self.theta_of).max(axis=0, initial=0.0)
        shown = np.abs(self.theta_of) > ZERO * size
        last = len(self.theta_of) - 1 - shown[::-1].argmax(axis=0)
        of_beta = last // PER_BODY
        return np.concatenate([of_beta, of_beta[self.sigma][self.pairs].max(axis=1)])

    def at(self, motion: "RandomMotion") -> "MomentumColumns":
        """What all columns are made of, in some motion."""
        at = momentum_regressors(self.robot, *motion)
        of_sigma = self._sparse_theta_of[:, self.sigma]
        return MomentumColumns(
            A=_times(at.A[:, self.axes], self._sparse_theta_of),
            S=_times(at.S, of_sigma),
            P=_times(at.P, of_sigma),
            columns=self,
        )

    @cached_property
    def _sparse_theta_of(self) -> csc_array:
        """Most of `beta` are one parameter of `theta` each."""
        return csc_array(self.theta_of)


def _times(
    X: Float[np.ndarray, "n k all"], Y: csc_array
) -> Float[np.ndarray, "n k some"]:
    """`X @ Y` as one product of two matrices, not as `n` of small ones."""
    n, k, size = X.shape
    return (X.reshape(n * k, size) @ Y).reshape(n, k, -1)


class RandomMotion(NamedTuple):
    """Samples of random motion."""

    q: Float[np.ndarray, "n joints"]
    qd: Float[np.ndarray, "n joints"]
    w: Float[np.ndarray, "n 3"]


def random_motion(
    n: int, joints: int, planar: bool, random: np.random.Generator | None = None
) -> RandomMotion:
    """Motion that has nothing special about it.

    In the plane the base turns about z alone. Without a generator the numbers are
    always the same ones.
    """
    random = random or np.random.default_rng(0)
    q, qd = random.standard_normal((2, n, joints))
    w = random.standard_normal((n, 3))
    if planar:
        w[:, :2] = 0.0
    return RandomMotion(q, qd, w)


@dataclass(frozen=True)
class MomentumColumns:
    """Columns of `h_rs` in some motion."""

    A: Float[np.ndarray, "n axes beta"]
    S: Float[np.ndarray, "n 3 sigma"]
    P: Float[np.ndarray, "n 3 sigma"]
    columns: Columns

    def of(self, which: Int[np.ndarray, " some"]) -> Float[np.ndarray, "rows some"]:
        """Some columns."""
        linear = which[which < self.A.shape[2]]
        a, b = self.columns.pairs[which[which >= self.A.shape[2]] - self.A.shape[2]].T
        products = np.where(a == b, -0.5, -1.0) * (
            np.cross(self.S[:, :, a], self.P[:, :, b], axis=1)
            + np.cross(self.S[:, :, b], self.P[:, :, a], axis=1)
        )
        X = np.concatenate(
            [self.A[:, :, linear], products[:, self.columns.axes]], axis=2
        )
        return X.reshape(X.shape[0] * X.shape[1], len(which))

    def along(self, N: Float[np.ndarray, "columns m"]) -> Float[np.ndarray, "rows m"]:
        """Combinations of all columns."""
        n, axes, beta = self.A.shape
        sigmas = self.S.shape[2]
        a, b = self.columns.pairs.T
        S, P = self.S.reshape(3 * n, sigmas), self.P.transpose(0, 2, 1)
        seen = self.A.reshape(n * axes, beta) @ N[:beta]
        for k, of_products in enumerate(N[beta:].T):
            # sum c_ab (S_a x P_b + S_b x P_a) = sum over b of (S C)_b x P_b.
            C = np.zeros((sigmas, sigmas))
            C[a, b] = of_products
            C += C.T
            C[np.diag_indices(sigmas)] /= 2
            M = (S @ C).reshape(n, 3, sigmas) @ P
            across = M[:, (1, 2, 0), (2, 0, 1)] - M[:, (2, 0, 1), (1, 2, 0)]
            seen[:, k] -= across[:, self.columns.axes].ravel()
        return seen


def dependencies(columns: Columns) -> Float[np.ndarray, "columns m"]:
    """All independent combinations of the columns that are zero in any motion."""
    random = np.random.default_rng(0)
    bodies = columns.bodies()
    found: list[Float[np.ndarray, "columns m"]] = []
    left = np.zeros((columns.count, 0))
    for body in reversed(range(len(columns.robot.bodies))):
        own = np.flatnonzero(bodies == body)
        unknowns = len(own) + left.shape[1]
        seen = columns.at(_by_rate_of(columns, body, unknowns, random))
        X = np.hstack([seen.of(own), seen.along(left)])
        of_own, of_left = np.split(_parted(X)[0], [len(own)])
        left = left @ of_left
        left[own] += of_own
        left[np.abs(left) < ROUNDING] = 0.0
        # What is zero in any motion need not be looked at again.
        everywhere = columns.at(_any_motion(columns, left.shape[1], random))
        zero, rest = _parted(everywhere.along(left))
        found.append(left @ zero)
        left = left @ rest
    return np.hstack(found)


def _parted(
    X: Float[np.ndarray, "rows n"],
) -> tuple[Float[np.ndarray, "n zero"], Float[np.ndarray, "n rest"]]:
    """Orthonormal combinations of columns that are zero, and all others."""
    R = np.linalg.qr(X, mode="r") / np.sqrt(len(X))
    _, s, Vt = np.linalg.svd(R)
    rank = int(np.sum(s > DEPENDENT * max(1.0, s.max(initial=0.0))))
    return Vt[rank:].T, Vt[:rank].T


def _by_rate_of(
    columns: Columns, body: int, unknowns: int, random: np.random.Generator
) -> RandomMotion:
    """Random configurations in which only this body's joint moves, or the base."""
    motion = _any_motion(columns, unknowns, random)
    qd, w = np.zeros_like(motion.qd), motion.w
    if body:
        qd[:, body - 1], w = 1.0, np.zeros_like(w)
    return RandomMotion(motion.q, qd, w)


def _any_motion(
    columns: Columns, unknowns: int, random: np.random.Generator
) -> RandomMotion:
    robot, n = columns.robot, int(SPARE * unknowns / len(columns.axes)) + FEWEST
    return random_motion(n, len(robot.joints), robot.motion == "planar", random)
