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

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float

from orbident.estimation.output_error.problem import Problem, common_factor, linear
from orbident.estimation.solution import Solution, Unknowns
from orbident.estimation.triangular import RANK, triangular_factor

SLIGHT = 1e-3
"""Square of the noise of a path over that of its motion, below which `N` is nothing:
deviations would change by a part as small as that, or a few of them."""

LEAST = 1e-2
"""Part of the information that is left, at least: what noise alone shows is not known,
and CAD says then how large it can be."""

SEED = 0
"""Of the draw of `e'`: all intervals are drawn, so that one draw is enough."""


@dataclass(frozen=True)
class NoiseAsMotion:
    """What noise of encoders shows, as if it were a motion."""

    problem: Problem
    solution: Solution
    """Of these equations."""

    @property
    def weakened(self) -> Solution:
        """The solution whose covariance is `C`."""
        return self._weakened(1.0)

    @property
    def gain(self) -> Solution:
        """The solution whose covariance is `(I - N)^-1`, which errors are times."""
        return self._weakened(0.5)

    def _weakened(self, power: float) -> Solution:
        solution, shown = self.solution, self.solution.linear.common
        whole = solution.prior.added(shown, solution.state)
        left = self.without(whole, shown, solution.linear.at, power)
        return solution if left is whole else solution._replace(weakened=left)

    def without(
        self,
        whole: Float[np.ndarray, "n n"],
        shown: Float[np.ndarray, "n n"],
        at: Unknowns,
        power: float = 1.0,
    ) -> Float[np.ndarray, "n n"]:
        """Equations of the common unknowns, as weak as they are without it.

        Args:
            whole: triangular, over changes of `[g, rhs]`: of samples, and of what is
                known beforehand.
            shown: of samples alone.
            at: where they were linearised; more may be selected than in the solution.
            power: of the part of the information that is left.
        """
        e = self._error
        if e is None:
            return whole
        weights, still = self.solution.weights, np.zeros(at.common.size)
        # To either side: what is linear in `e'` is zero on average.
        sides = [
            common_factor(self.problem, weights, at.moved(side * e, still))
            for side in (1.0, -1.0)
        ]
        size = np.linalg.norm(whole[:, :-1], axis=0)
        size = np.where(size > 0, size, 1.0)
        U, s, Vt = np.linalg.svd(whole[:-1, :-1] / size)
        seen = s > RANK * s.max()
        # Over directions in each of which the information is one.
        inverse = Vt[seen].T / s[seen] / size[:, None]
        here, *moved = (
            information.T @ information
            for information in (part[:, :-1] @ inverse for part in (shown, *sides))
        )
        share, axes = np.linalg.eigh((moved[0] + moved[1]) / 2 - here)
        left = np.clip(1 - share, LEAST, 1.0) ** power
        rows = (axes * left) @ axes.T @ U[:, seen].T @ whole[:-1]
        nothing = np.zeros_like(whole)
        return triangular_factor(np.vstack([rows, whole[-1:], nothing]))

    @cached_property
    def _error(self) -> Float[np.ndarray, "boundaries local"] | None:
        """`e'` of all that belongs to boundaries; None where noise shows nothing.

        Equations `A z = b + n` have the errors `A^-1 n`, with `n` of unit variances.
        """
        if self._noise_over_motion() < SLIGHT:
            return None
        here = self.solution.linear
        if here.given_up:
            here = linear(self.problem, self.solution.weights, here.at)
        random = np.random.default_rng(SEED)
        links, factor, n = here.links.copy(), here.factor.copy(), here.local
        links[:, :, -1] = random.standard_normal(links.shape[:2])
        factor[:n, -1] = random.standard_normal(n)
        drawn = here._replace(links=links, factor=factor)
        return drawn.step(np.zeros(here.at.common.size))

    def _noise_over_motion(self) -> float:
        """The square of both, where joints together move least beside their noise.

        Of positions about their mean, or of rates, whichever is larger.
        """
        problem, solution = self.problem, self.solution
        joints = problem.loose.corrected.astype(int)
        if not joints.size:
            return 0.0
        history, t = problem.acting.followed.intervals.history, problem.boundaries
        # Corrections come last: of all positions, then of all rates.
        first = problem.recorded.local - 2 * joints.size
        std = np.sqrt(np.diag(solution.covariance)[first : problem.recorded.local])
        own = solution.state.local[:, first:]
        q = history.at(history.q, history.q_slope, t)[:, joints]
        qd = history.at(history.qd, history.qdd, t)[:, joints]
        q, qd = np.hsplit((np.hstack([q, qd]) + own) / std, 2)
        least = [np.linalg.norm(x, -2) ** 2 / len(x) for x in (q - q.mean(axis=0), qd)]
        return float(1 / min(least)) if min(least) else np.inf
