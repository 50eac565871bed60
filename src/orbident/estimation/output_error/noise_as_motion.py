"""What noise of encoders shows is not what a motion shows.

Parameters are learnt from how joints move. What a fit takes for their path `x` has an
error `e` of covariance `P`, and seems to show parameters as the path does. The
information is quadratic in the path:

    E I(x + e) = I(x) + N,    N = E I(x + e + e') - I(x + e)

with `e'` drawn from `P` again. Errors of a path pull the estimate as well, so that its
covariance is (Fuller 1987, Measurement Error Models, section 1.3)

    C = (I - N)^-1 I (I - N)^-1

Where joints move far more than encoders are noisy, `N` is nothing. Where one hardly
moves, `N` is nearly all, and what only that joint shows is hardly known.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.linalg import solve_triangular

from orbident.estimation.output_error.problem import Problem, common_factor, linear
from orbident.estimation.solution import Solution, Unknowns
from orbident.estimation.triangular import RANK, triangular_factor

SLIGHT = 1e-2
"""Part of the information that is nothing: deviations change by as little. Where a
path's noise, squared, is a smaller part of its motion, nothing is drawn."""

MOST = 0.7
"""Part of the information beyond which noise shows it all: `N` is that of one path, and
what is left, less than a third, may be by chance."""

LEAST = 1e-2
"""What is left then: deviations are a hundred times as large."""

DRAWS = 8
"""How many errors `e'` are drawn at most, and averaged. Where few samples show what
joints do, deviations changed by factors of ten from draw to draw; where many do, two
draws are as good as eight."""


class _Shares(NamedTuple):
    """How much of the information noise shows, by directions in which it is one."""

    rows: Float[np.ndarray, "directions n"]
    """What is known along each of them, over `[g, rhs]`."""
    axes: Float[np.ndarray, "directions directions"]
    shares: Float[np.ndarray, " directions"]
    """Along each of the axes."""

    def left(self, power: float) -> Float[np.ndarray, "n n"]:
        """The equations without it, triangular.

        Args:
            power: of the part of the information that is left.
        """
        part = np.where(self.shares < MOST, 1 - self.shares, LEAST)
        part = np.minimum(part, 1.0) ** power
        rows = (self.axes * part) @ self.axes.T @ self.rows
        return triangular_factor(np.vstack([rows, np.zeros(2 * rows.shape[1:])]))


def _settled(N: Float[np.ndarray, "draws n n"], axes: Float[np.ndarray, "n n"]) -> bool:
    """Whether the mean of some draws is as sure along all axes as deviations need."""
    along = np.einsum("ki,dkl,li->di", axes, N, axes)
    std = along.std(axis=0, ddof=1) / np.sqrt(len(N))
    return bool(std.max() < SLIGHT)


@dataclass(frozen=True)
class NoiseAsMotion:
    """What noise of encoders shows, as if it were a motion."""

    problem: Problem
    solution: Solution
    """The fit of this problem."""

    @property
    def weakened(self) -> Solution:
        """The solution whose covariance is `C`."""
        return self._weakened(1.0)

    @property
    def gain(self) -> Solution:
        """The solution whose covariance is `(I - N)^-1`, which errors are times."""
        return self._weakened(0.5)

    def _weakened(self, power: float) -> Solution:
        if self._own is None:
            return self.solution
        return self.solution._replace(weakened=self._own.left(power))

    def without(
        self,
        whole: Float[np.ndarray, "n n"],
        shown: Float[np.ndarray, "n n"],
        at: Unknowns,
    ) -> Float[np.ndarray, "n n"]:
        """Equations of the common unknowns, as weak as they are without it.

        Args:
            whole: triangular, over changes of `[g, rhs]`: of samples, and of what is
                known beforehand.
            shown: of samples alone.
            at: where they were linearised; more may be selected than in the solution.
        """
        if self._own is None:
            return whole
        return self._shares(whole, shown, at).left(1.0)

    @cached_property
    def _own(self) -> _Shares | None:
        """That of the solution's own unknowns; None where it is nothing."""
        # Where a search ended nowhere, errors of its path say nothing.
        if not self.solution.converged or self._noise_over_motion() < SLIGHT:
            return None
        here = self.solution.linear
        whole = self.solution.prior.added(here.common, self.solution.state)
        own = self._shares(whole, here.common, here.at)
        return own if own.shares.max() > SLIGHT else None

    def _shares(
        self,
        whole: Float[np.ndarray, "n n"],
        shown: Float[np.ndarray, "n n"],
        at: Unknowns,
    ) -> _Shares:
        size = np.linalg.norm(whole[:, :-1], axis=0)
        size = np.where(size > 0, size, 1.0)
        U, s, Vt = np.linalg.svd(whole[:-1, :-1] / size)
        seen = s > RANK * s.max()
        inverse = Vt[seen].T / s[seen] / size[:, None]

        def information(factor: Float[np.ndarray, "n n"]) -> np.ndarray:
            root = factor[:, :-1] @ inverse
            return root.T @ root

        known, N = information(shown), list[np.ndarray]()
        shares, axes = np.zeros(0), np.zeros((0, 0))
        for moved in self._moved(at):
            N.append(np.mean([information(each) for each in moved], axis=0) - known)
            shares, axes = np.linalg.eigh(np.mean(N, axis=0))
            if len(N) > 1 and _settled(np.array(N), axes):
                break
        return _Shares(U[:, seen].T @ whole[:-1], axes, shares)

    def _moved(self, at: Unknowns) -> Iterator[list[Float[np.ndarray, "n n"]]]:
        """What samples show of common unknowns where paths are moved by errors.

        To either side: what is linear in `e'` is zero on average.
        """
        weights, still = self.solution.weights, np.zeros(at.common.size)
        for e in self._errors:
            yield [
                common_factor(self.problem, weights, at.moved(moved, still))
                for moved in (e, -e)
            ]

    @cached_property
    def _errors(self) -> list[Float[np.ndarray, "boundaries local"]]:
        """Draws of `e'`, of all that belongs to boundaries.

        Equations `A z = b + n` have the errors `A^-1 n`, with `n` of unit variances.
        """
        here = self.solution.linear
        if here.given_up:
            here = linear(self.problem, self.solution.weights, here.at)
        drawn = here._replace(links=here.links.copy(), factor=here.factor.copy())
        random, still = np.random.default_rng(0), np.zeros(here.at.common.size)
        errors = []
        for _ in range(DRAWS):
            for rows in (drawn.links, drawn.factor[: here.local]):
                rows[..., -1] = random.standard_normal(rows.shape[:-1])
            errors.append(drawn.step(still))
        return errors

    def _noise_over_motion(self) -> float:
        """The square of both, where joints together move least beside their noise.

        Of positions about their mean, or of rates, whichever is larger. The noise is
        that where intervals meet, with all that they have in common known.
        """
        problem, solution = self.problem, self.solution
        joints = problem.loose.corrected.astype(int)
        if not joints.size:
            return 0.0
        history, t = problem.acting.followed.intervals.history, problem.boundaries
        # Corrections come last: of all positions, then of all rates.
        n = problem.recorded.local
        first = n - 2 * joints.size
        root = solve_triangular(solution.linear.factor[:n, :n], np.eye(n))
        std = np.linalg.norm(root[first:], axis=1)
        own = solution.state.local[:, first:]
        q = history.at(history.q, history.q_slope, t)[:, joints]
        qd = history.at(history.qd, history.qdd, t)[:, joints]
        q, qd = np.hsplit((np.hstack([q, qd]) + own) / std, 2)
        least = [np.linalg.norm(x, -2) ** 2 / len(x) for x in (q - q.mean(axis=0), qd)]
        return float(1 / min(least)) if min(least) else np.inf
