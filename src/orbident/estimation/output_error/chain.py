"""A recording's segments one after another: all equations at a state, eliminated."""

from collections.abc import Iterator
from functools import partial
from typing import NamedTuple

import jax
import numpy as np
from jaxtyping import Float

from orbident.compilation import compiled
from orbident.estimation.output_error.course import BATCH, Chart
from orbident.estimation.output_error.segment import Point, Rows, linearised
from orbident.estimation.output_error.sweep import Known, swept
from orbident.estimation.output_error.terms import Body
from orbident.estimation.output_error.unknowns import LOCAL, OWN, Own

MOMENT = 1e-3
"""s: segments that only fill up last no time."""


class State(NamedTuple):
    """Where the equations are linearised."""

    x_WB: Float[np.ndarray, "boundaries 4"]
    """The attitude where segments meet."""
    local: Float[np.ndarray, "boundaries local"]
    """Turn (always zero), biases, corrections of the joints and of their rates."""
    common: Float[np.ndarray, " common"]
    """`h_cm`, `v_cm`, `r_cm`, torque, pull and `beta`."""

    @property
    def beta(self) -> Float[np.ndarray, " beta"]:
        """`[M, sigma, iota]`."""
        return self.common[OWN - LOCAL :]

    def moved(
        self, z: Float[np.ndarray, "boundaries local"], g: Float[np.ndarray, " common"]
    ) -> "State":
        """The state after a step."""
        turn, v, s = z[:, :3], self.x_WB[:, :3], self.x_WB[:, 3:]
        vector = v + (s * turn + np.cross(v, turn)) / 2
        x = np.hstack([vector, s - np.sum(v * turn, axis=1, keepdims=True) / 2])
        local = self.local + z
        local[:, :3] = 0.0
        unit = x / np.linalg.norm(x, axis=1, keepdims=True)
        return State(unit, local, self.common + g)


class Loose(NamedTuple):
    """How freely what belongs to segments may vary: standard deviations."""

    first: Float[np.ndarray, " local"]
    """At the recording's start."""
    corrections: Float[np.ndarray, " corrections"]
    """Of the joints, rad or m, and of their rates, per second, anywhere."""
    walk: Float[np.ndarray, "9"]
    """Of attitude and biases, per square root of a second."""


class Problem(NamedTuple):
    """A robot and what was recorded of it."""

    body: Body
    planar: bool
    substeps: int
    """Of the attitude, from row to row."""
    chart: Chart
    loose: Loose


class Linear(NamedTuple):
    """All equations at a state, linear in changes of it."""

    known: Known
    cost: float
    """Sum of the squared whitened residuals and defects."""
    residuals: dict[str, Float[np.ndarray, "segments rows axes"]]
    """Whitened, by sensor; zero where there was no sample."""


def linear(problem: Problem, state: State) -> Linear:
    """Linearise all segments and eliminate what belongs to one of them alone."""
    residuals: list[np.ndarray] = []
    before = _beforehand(problem, state)
    cost = float(before[:, -1] @ before[:, -1])

    def segments() -> Iterator[Float[np.ndarray, "_ columns"]]:
        nonlocal cost
        for start, rows in _batches(problem, state):
            for k in range(len(rows.residual)):
                equations = _equations(problem, state, rows, start, k)
                cost += float(equations[:, -1] @ equations[:, -1])
                yield equations
            residuals.extend(rows.residual)

    factor = np.zeros((before.shape[1],) * 2)
    factor[: len(before)] = before
    known = swept(factor, segments(), state.local.shape[1])
    return Linear(known, cost, _by_sensor(problem, residuals))


def _by_sensor(
    problem: Problem, residuals: list[np.ndarray]
) -> dict[str, Float[np.ndarray, "segments rows axes"]]:
    table, first, parts = np.array(residuals), 0, {}
    for sensor, weights in sorted(problem.chart.shown.weights.items()):
        axes = weights.shape[-1]
        parts[sensor] = table[..., first : first + axes]
        first += axes
    return parts


def _beforehand(problem: Problem, state: State) -> Float[np.ndarray, "local columns"]:
    """Of the first segment's own unknowns."""
    local = state.local.shape[1]
    rows = np.zeros((local, local + state.common.size + 1))
    rows[:, :local] = np.eye(local)
    rows[:, -1] = -state.local[0]
    return rows / problem.loose.first[:, None]


def _batches(problem: Problem, state: State) -> Iterator[tuple[int, Rows]]:
    body, planar, substeps, chart, _ = problem
    K = chart.course.joints.q.shape[-1]
    corrections = state.local[:, LOCAL:].reshape(len(state.local), 2, K)
    both = np.concatenate([corrections[:-1], corrections[1:]], axis=1)
    for start in range(0, len(both), BATCH):
        part = slice(start, start + BATCH)
        local = state.local[:-1][part, :LOCAL]
        common = np.tile(state.common[: OWN - LOCAL], (len(local), 1))
        own = Own(*np.split(np.hstack([local, common]), len(Own._fields), axis=1))
        at = Point(state.x_WB[:-1][part], own, both[part])
        here = jax.tree.map(lambda x, part=part: x[part], (chart.course, chart.shown))
        rows = _linearised(body, planar, substeps, state.beta, at, *here)
        yield start, jax.tree.map(np.asarray, rows)


@partial(compiled, static_argnames=("planar", "substeps"))
def _linearised(body, planar, substeps, beta, at, course, shown):
    one = partial(linearised, body, planar, substeps, beta)
    return jax.vmap(one)(at, course, shown)


def _equations(
    problem: Problem, state: State, rows: Rows, start: int, k: int
) -> Float[np.ndarray, "_ columns"]:
    """Of one segment, over `[z_s, z_{s+1}, g, rhs]`."""
    s = start + k
    local, n = state.local.shape[1], rows.slopes.shape[-1]
    # Where the columns [own, corrections, beta] of a segment's rows belong.
    place = np.r_[
        :LOCAL,
        2 * local : 2 * local + OWN - LOCAL,
        LOCAL:local,
        local + LOCAL : 2 * local,
        2 * local + OWN - LOCAL : 2 * local + state.common.size,
    ]
    sensed = rows.residual[k].size
    table = np.zeros((sensed + local, 2 * local + state.common.size + 1))
    table[:sensed, place] = rows.slopes[k].reshape(sensed, n)
    table[:sensed, -1] = rows.residual[k].ravel()

    # Attitude and biases at the end are those at the next segment's start.
    going_on = table[sensed : sensed + LOCAL]
    going_on[:3, place] = rows.end_slopes[k]
    going_on[:3, -1] = -_turned(state.x_WB[s + 1], np.asarray(rows.end[k]))
    going_on[3:, 3:LOCAL] = np.eye(LOCAL - 3)
    going_on[3:, -1] = (state.local[s + 1] - state.local[s])[3:LOCAL]
    going_on[:, local : local + LOCAL] = -np.eye(LOCAL)
    duration = max(problem.chart.t[s + 1] - problem.chart.t[s], MOMENT)
    going_on /= problem.loose.walk[:, None] * np.sqrt(duration)

    correcting = table[sensed + LOCAL :]
    std = problem.loose.corrections
    correcting[:, local + LOCAL : 2 * local] = np.diag(1 / std)
    correcting[:, -1] = -state.local[s + 1, LOCAL:] / std
    return table


def _turned(
    a: Float[np.ndarray, "4"], b: Float[np.ndarray, "4"]
) -> Float[np.ndarray, "3"]:
    """The small rotation from `a` to `b`, axes of `a`."""
    vector = a[3] * b[:3] - b[3] * a[:3] - np.cross(a[:3], b[:3])
    return 2 * np.copysign(1.0, a @ b) * vector
