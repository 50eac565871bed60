"""Where the likelihood is largest: the unknowns there, and the equations about them.

A search has converged when its steps became small. What recordings of one robot have
in common is base parameters and errors of instruments; momentum, attitudes, biases and
what acts from outside are each one's own. Equations of a recording without its own
unknowns, `R x = z` of `x = [beta | errors]`, are all that another one needs: with them
it is fitted as if both were fitted at once.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.linalg import solve_triangular

from orbident import _core
from orbident.estimation.triangular import fold, triangular_factor
from orbident.estimation.unknowns import Unknown
from orbident.files.json_parts import Count, Keyed, NullableNumber

SMALL = 1e-2
"""Standard deviations: a search ends with a step that is smaller than this."""


class Step(NamedTuple):
    """One step of a search."""

    cost: NullableNumber
    """After the step: the sum of the squares of all whitened residuals and priors."""
    size: NullableNumber
    """How far the step led, in standard deviations of the parameters: none moved by
    more of its own. NaN where a round starts."""
    round: Count = 1
    """Each round weighs residuals by the noise and outliers that the one before it
    showed, so costs of different rounds cannot be compared."""


Convergence = tuple[Keyed[Step], ...]
"""All steps of a search, in order; none for a method that solves its equations once."""


NOTHING_SELECTED = np.zeros(0)
"""Every instrument is perfect."""


BySensor = Mapping[str, Float[np.ndarray, "rows axes"]]


class Outside(NamedTuple):
    """The first common unknowns; the core's `outside.hpp` has the same order."""

    h_cm: Float[np.ndarray, "3"]
    """Angular momentum at time zero, inertial axes, N m s."""
    v_cm: Float[np.ndarray, "3"]
    """Velocity of the system CM at time zero, inertial axes, m/s."""
    r_cm: Float[np.ndarray, "3"]
    """Position of the system CM at time zero, inertial axes, m."""


OUTSIDE = 3 * len(Outside._fields)
"""How many numbers they are."""


class Unknowns(NamedTuple):
    """Where the equations are linearised."""

    x_WB: Float[np.ndarray, "boundaries 4"]
    """The attitude where intervals meet."""
    local: Float[np.ndarray, "boundaries local"]
    """Turn (always zero), biases, lasting noise, corrections of joints and rates."""
    common: Float[np.ndarray, " common"]
    """`h_cm`, `v_cm`, `r_cm`, `beta` and what is selected."""
    selected: Float[np.ndarray, " selected"] = NOTHING_SELECTED
    """Places of the calibrations, then of the disturbances, that are unknowns; all
    others are zero."""

    @property
    def beta(self) -> Float[np.ndarray, " beta"]:
        """`[M, sigma, iota]`."""
        return self.common[OUTSIDE : self.common.size - self.selected.size]

    @property
    def calibration(self) -> Float[np.ndarray, " selected"]:
        """Errors of instruments, SI or relative, and sizes of disturbances."""
        return self.common[self.common.size - self.selected.size :]

    def selecting(self, places: Float[np.ndarray, " selected"]) -> "Unknowns":
        """The state with these as unknowns too, at zero."""
        return self._replace(
            common=np.append(self.common, np.zeros(places.size)),
            selected=np.append(self.selected, places),
        )

    def carried(self, places: Float[np.ndarray, " selected"]) -> "Unknowns":
        """The state with these alone selected; those that were not are zero."""
        values = dict(zip(self.selected, self.calibration, strict=True))
        own = self.common[: self.common.size - self.selected.size]
        chosen = [values.get(place, 0.0) for place in places]
        return self._replace(common=np.append(own, chosen), selected=places)

    def at(self, boundaries: Bool[np.ndarray, " boundaries"]) -> "Unknowns":
        """The state with some boundaries alone."""
        x_WB, local = self.x_WB[boundaries], self.local[boundaries]
        return self._replace(x_WB=x_WB, local=local)

    @property
    def ratios(self) -> list[int]:
        """Places of what the motion shows as ratios to the mass, and of the mass."""
        return [0, 1, 2, *range(OUTSIDE, self.common.size - self.selected.size)]

    def grown(self, g: Float[np.ndarray, " common"]) -> float:
        """How many times as large the mass is after a step.

        Wheels show its inverse, which changes along a line: where little shows it, it
        may pass through zero, and the mass through infinity.
        """
        with np.errstate(divide="ignore"):
            return float(1 / (1 - g[OUTSIDE] / self.common[OUTSIDE]))

    def moved(
        self, z: Float[np.ndarray, "boundaries local"], g: Float[np.ndarray, " common"]
    ) -> "Unknowns":
        """The state after a step; one that is far too long leads to no number.

        The motion shows ratios to the mass, which change along a line: with `x` a
        momentum or an inertia,

            x' / M' = x / M + (dx - x dM / M) / M
        """
        turn, v, s = z[:, :3], self.x_WB[:, :3], self.x_WB[:, 3:]
        local = self.local + z
        local[:, :3] = 0.0
        common = self.common + g
        of_ratios = self.ratios
        x = self.common[of_ratios]
        with np.errstate(over="ignore", invalid="ignore"):
            shown = common[of_ratios] - x * (g[OUTSIDE] / self.common[OUTSIDE])
            common[of_ratios] = self.grown(g) * shown
            vector = v + (s * turn + np.cross(v, turn)) / 2
            x = np.hstack([vector, s - np.sum(v * turn, axis=1, keepdims=True) / 2])
            unit = x / np.linalg.norm(x, axis=1, keepdims=True)
        return self._replace(x_WB=unit, local=local, common=common)


class Linear(NamedTuple):
    """All equations at a state, linear in changes of it, with `z` eliminated."""

    factor: Float[np.ndarray, "n n"]
    """Triangular, over `[z, g, rhs]` with the `z` of the meeting boundary."""
    links: Float[np.ndarray, "intervals local columns"]
    """Rows of each interval over `[z, z on the meeting boundary's side, g, rhs]`."""
    cost: float
    """Sum of the squared whitened residuals and defects."""
    residuals: dict[str, Float[np.ndarray, "rows axes"]]
    """Over the white noise; zero where there was no sample."""
    at: Unknowns
    """The state."""

    def without_rows(self) -> "Linear":
        """These equations without their large parts, links and residuals."""
        return self._replace(links=self.links[:0].copy(), residuals={})

    def carried(self, places: Float[np.ndarray, " selected"]) -> "Linear":
        """The equations with these of the selected alone, where all others are zero."""
        own = self.at.selected
        if np.array_equal(own, places):
            return self
        gone = np.flatnonzero(~np.isin(own, places)) - own.size - 1
        factor = np.delete(self.factor, gone, axis=1)
        links = np.delete(self.links, gone, axis=2)
        return self._replace(
            factor=triangular_factor(factor), links=links, at=self.at.carried(places)
        )

    @property
    def given_up(self) -> bool:
        """Whether that is so."""
        return not len(self.links)

    @property
    def local(self) -> int:
        """How many unknowns a boundary has."""
        return self.links.shape[1]

    @property
    def common(self) -> Float[np.ndarray, "n n"]:
        """The part of the factor over `[g, rhs]`."""
        return self.factor[self.local :, self.local :]

    def step(self, g: Float[np.ndarray, " g"]) -> Float[np.ndarray, "boundaries local"]:
        """`z` of every boundary, for any `g`."""
        n = self.local
        top = self.factor[:n]
        z = solve_triangular(top[:, :n], top[:, -1] - top[:, n:-1] @ g)
        return _core.boundaries(self.links, z, g)

    def at_the_end(self) -> "End":
        """The last boundary's `z`, from that of `[z, g]` at the meeting.

        Each link gives `R z = e - F z_before - G g`, with `e` of unit covariance.
        """
        n = self.local
        by, own = np.eye(n, len(self.factor) - 1), np.zeros((n, n))
        # One after another: a table of all would be as large as the links.
        for link in self.links[len(self.links) // 2 :]:
            solved = np.linalg.solve(
                link[:, :n], np.hstack([np.eye(n), -link[:, n:-1]])
            )
            root, on = solved[:, :n], solved[:, n : 2 * n]
            # A search that led nowhere may end where intervals have nothing in common.
            with np.errstate(over="ignore", invalid="ignore"):
                by = on @ by
                by[:, n:] += solved[:, 2 * n :]
                own = on @ own @ on.T + root @ root.T
        return End(by, own)


class End(NamedTuple):
    """The last boundary's `z`, as `by [z, g] + N(0, own)` of the meeting one."""

    by: Float[np.ndarray, "local unknowns"]
    own: Float[np.ndarray, "local local"]

    def covariance(
        self, C: Float[np.ndarray, "unknowns unknowns"]
    ) -> Float[np.ndarray, "local local"]:
        """From that of `[z, g]` at the meeting."""
        return self.by @ C @ self.by.T + self.own


NO_EQUATIONS = np.zeros((0, 1))
"""What is known without another recording of the robot."""


class Prior(NamedTuple):
    """What is known of the common unknowns beforehand."""

    values: Float[np.ndarray, " common"]
    std: Float[np.ndarray, " common"]
    others: Float[np.ndarray, "rows columns"] = NO_EQUATIONS
    """Whitened equations over the first unknowns, `[A, b]`: of other recordings."""
    measured: Float[np.ndarray, "rows columns"] = NO_EQUATIONS
    """The same of what scales and balances said."""
    carried: Float[np.ndarray, "rows columns"] = NO_EQUATIONS
    """The same of what passive joints carry."""
    held: Float[np.ndarray, "rows columns"] = NO_EQUATIONS
    """Equations that hold parameters which no sensor shows at their nominal values."""

    @property
    def equations(self) -> tuple[Float[np.ndarray, "rows columns"], ...]:
        """All equations."""
        return self.others, self.measured, self.carried, self.held

    def extended(self, std: Float[np.ndarray, " more"]) -> "Prior":
        """The prior with more unknowns, which are zero with these deviations."""
        return self._replace(
            values=np.append(self.values, np.zeros(std.size)),
            std=np.append(self.std, std),
        )

    def added(
        self, factor: Float[np.ndarray, "n n"], state: Unknowns
    ) -> Float[np.ndarray, "n n"]:
        """Add the prior to a triangular factor over changes of `[g, rhs]`."""
        rhs = (self.values - state.common) / self.std
        factor = fold(factor, np.column_stack([np.diag(1 / self.std), rhs]))
        for equations in self.equations:
            if len(equations):
                first = equations.shape[1] - 1
                rows = np.zeros((len(equations), len(factor)))
                rows[:, :first] = equations[:, :-1]
                rows[:, -1] = _unexplained(equations, state)
                factor = fold(factor, rows)
        return factor

    def slope(self, state: Unknowns) -> Float[np.ndarray, " common"]:
        """Half the derivatives of the cost."""
        by = (state.common - self.values) / self.std**2
        for x in self.equations:
            by[: x.shape[1] - 1] -= x[:, :-1].T @ _unexplained(x, state)
        return by

    def cost(self, state: Unknowns) -> float:
        """Squared, whitened."""
        own = (state.common - self.values) / self.std
        more = (_unexplained(x, state) for x in self.equations)
        return float(np.sum(own**2) + sum(np.sum(each**2) for each in more))


def _unexplained(
    equations: Float[np.ndarray, "rows columns"], state: Unknowns
) -> Float[np.ndarray, " rows"]:
    A, b = equations[:, :-1], equations[:, -1]
    return b - A @ state.common[: A.shape[1]]


class Solution(NamedTuple):
    """Where the cost is least."""

    state: Unknowns
    linear: Linear
    """The equations at a state within a hundredth of a deviation of `state`; without
    links where these take much memory."""
    last: End | None
    """The last boundary's `z`, where the links are left out."""
    prior: Prior
    weights: BySensor
    converged: bool
    cost: float
    """The sum of the squares of all whitened residuals and priors."""
    convergence: Convergence = ()
    """How the search got there."""
    names: tuple[str, ...] = ()
    """The names of the unknowns that the state selects, in its order."""
    weakened: Float[np.ndarray, "n n"] | None = None
    """Triangular, over `[g, rhs]`: all that is known of `g`, without what noise shows;
    None where that is nothing."""

    @property
    def covariance(self) -> Float[np.ndarray, "n n"]:
        """The covariance of `[z, g]`, `z` of the meeting boundary, to first order."""
        n = self.linear.local
        factor = self.linear.factor.copy()
        known = self.weakened
        if known is None:
            known = self.prior.added(self.linear.common, self.state)
        factor[n:, n:] = known
        root = solve_triangular(factor[:-1, :-1], np.eye(len(factor) - 1))
        return np.asarray(root @ root.T)

    @property
    def end(self) -> End:
        """The last boundary's `z`."""
        return self.last or self.linear.at_the_end()

    @property
    def left(self) -> float:
        """The fall in cost that the equations at this state expect of another step.

        NaN where a search led nowhere and its equations overflow.
        """
        with np.errstate(over="ignore", invalid="ignore"):
            whole = self.prior.added(self.linear.common, self.state)[:-1, -1]
            return float(whole @ whole)

    @property
    def mass(self) -> tuple[float, float]:
        """The total mass and its deviation, kg."""
        C, common = self.covariance, self.state.common
        place = len(C) - common.size + OUTSIDE
        return float(common[OUTSIDE]), float(np.sqrt(C[place, place]))


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
        return triangular_factor(np.vstack([known, rows]))[m : rows.shape[1] - 1, m:]


def together(parts: Sequence[Shared]) -> Shared:
    """What several recordings say.

    Args:
        parts: what each of them says; the last was linearised nearest to the truth.
    """
    errors = {each.name: each for part in parts for each in part.errors}
    every = tuple(errors.values())
    rows = np.vstack([part.over(every) for part in parts])
    return Shared(parts[-1].beta, every, triangular_factor(rows)[: rows.shape[1] - 1])
