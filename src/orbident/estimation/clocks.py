"""Whether the clock of joints and wheels agrees with that of the base's sensors.

Joints seen too late predict a base that turns too late. With `l` the delay, to first
order, the momentum equation gets one more unknown:

    Y pi + l d/dt|_joints (Y pi + A_rw qd_rw) - R_0^T h_cm = -A_rw qd_rw

where the derivative is that of joints and wheels alone, the base held. It is repeated
with joints moved by what was found.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float
from scipy.integrate import cumulative_trapezoid
from scipy.interpolate import CubicSpline

from orbident.dynamics.wheels import Wheels, wheels_of
from orbident.estimation.least_squares import (
    BATCH,
    InitialMomentum,
    KnownMomentum,
    known_momentum,
    momentum_layout,
    rows_of,
)
from orbident.estimation.triangular import Layout, LinearFit, solve
from orbident.recordings.recording import Recording
from orbident.regressors.minimal_sets import MinimalSets, Regressors
from orbident.robot.description import Robot
from orbident.signals.attitude_delay import attitude_delay
from orbident.signals.base_motion import AXES as GYRO
from orbident.signals.base_motion import QUATERNION as ATTITUDE
from orbident.signals.base_motion import SMOOTHED
from orbident.signals.delays import SETTLED, Delay, delay_of
from orbident.signals.samples import Batch, Samples
from orbident.spatial.arrays import AnyArray

NUMBERS = 2**22
"""Of all equations together; of a longer recording the middle is enough."""

MOST = 2**16
"""Samples."""

ROUNDS = 8
STRETCHES = 20
"""Of a recording, each taken to err for itself."""

NOMINAL = 0.3
"""Std of `pi` about its nominal value, over its size."""


def base_clocks(recording: Recording) -> dict[str, Delay]:
    """That of the attitude against the gyro's, where there are both."""
    if not recording.has(*GYRO, *ATTITUDE):
        return {}
    w, fixes = (
        np.column_stack([recording.column(name) for name in names])
        for names in (GYRO, ATTITUDE)
    )
    rows = _middle(np.isfinite(w).all(axis=1), MOST)
    delay = attitude_delay(recording.t[rows], w[rows], fixes[rows])
    return {} if delay is None else {"attitude": delay}


def joint_clocks(
    robot: Robot,
    sets: MinimalSets,
    samples: Samples,
    initial_momentum: InitialMomentum,
) -> dict[str, Delay]:
    """That of joints and wheels against the base rate's, where it can show.

    It cannot where no joint moves, or nothing spins that gives the momentum a scale.
    """
    spinning = any(np.nanmax(np.abs(speed)) > 0 for speed in samples.qd_rw)
    if len(samples.locked) == len(samples.q) or not spinning:
        return {}
    return {"joints": joint_delay(robot, sets, samples, initial_momentum)}


def in_words(clocks: Mapping[str, Delay]) -> tuple[str, ...]:
    """What was corrected."""
    names = {"joints": "joints and wheels", "attitude": "attitude and position"}
    return tuple(
        f"the clock of {names[sensor]} is {1e3 * delay.late:.2f} +- "
        f"{1e3 * delay.std:.2g} ms behind that of the base rate: corrected"
        for sensor, delay in clocks.items()
        if delay.believed
    )


def joint_delay(
    robot: Robot,
    sets: MinimalSets,
    samples: Samples,
    initial_momentum: InitialMomentum,
) -> Delay:
    """The delay of joints and wheels that makes the momentum fit best.

    `pi` starts from nominal inertia, and is held near it where the motion hardly shows
    it: noise that parameters take up would look like a delay.

    Args:
        robot: whose recording it is.
        sets: its minimal sets.
        samples: with joints and wheels as they were recorded.
        initial_momentum: as `identify` has it.
    """
    known = known_momentum(robot, sets, samples, initial_momentum)
    pi = sets.pi(robot.theta)
    derived = samples.origins["base_rate"] == SMOOTHED
    equations = _Equations(sets.regressors, wheels_of(robot), known, pi, derived)
    moving, late, before = _Moving.of(_part(samples, pi.size)), 0.0, None
    for _ in range(ROUNDS):
        found = equations.fit(*moving.at(late), pi)
        before = found.before if before is None else before
        late, pi = late + found.change, found.pi
        if abs(found.change) < max(SETTLED, found.std / 10):
            break
    return delay_of(late, found.std, found.change, before, found.after)


def _part(samples: Samples, unknowns: int) -> Samples:
    """As much of the middle as there is room for the equations of."""
    axes = len(samples.w)
    seen = np.logical_and.reduce([~np.isnan(w) for w in samples.w])
    rows = _middle(seen, min(MOST, NUMBERS // (axes * unknowns)))
    names = ("q", "qd", "w", "x_WB", "qd_rw")
    parts = {
        name: tuple(column[rows] for column in getattr(samples, name)) for name in names
    }
    return replace(samples, t=samples.t[rows], v_S=(), drift=(), **parts)


def _middle(seen: Bool[np.ndarray, " n"], most: int) -> slice:
    """Rows in the middle, of which at most so many are seen."""
    rows = np.flatnonzero(seen)
    if rows.size <= most:
        return np.s_[:]
    start = (rows.size - most) // 2
    return np.s_[rows[start] : rows[start + most]]


class _Moving(NamedTuple):
    """Joints and wheels of some samples as functions of time."""

    samples: Samples
    history: CubicSpline
    """Of `[q, qd, qd_rw]`."""

    @classmethod
    def of(cls, samples: Samples) -> "_Moving":
        table = np.column_stack([*samples.q, *samples.qd, *samples.qd_rw])
        known = np.isfinite(table).all(axis=1)
        spline = CubicSpline(samples.t[known], table[known], extrapolate=False)
        return cls(samples, spline)

    def at(self, late: float) -> tuple[Samples, Float[np.ndarray, "n rates"]]:
        """The samples with joints and wheels of so much later; `[qdd, qdd_rw]`."""
        samples, joints = self.samples, len(self.samples.q)
        columns = tuple(self.history(samples.t + late).T)
        moved = replace(
            samples,
            q=columns[:joints],
            qd=columns[joints : 2 * joints],
            qd_rw=columns[2 * joints :],
        )
        return moved, self.history(samples.t + late, nu=1)[:, joints:]


class _Round(NamedTuple):
    change: float
    std: float
    pi: Float[np.ndarray, " pi"]
    before: float
    """Norm of the residual without a change of the delay."""
    after: float


class _Equations(NamedTuple):
    """The momentum equation with the delay as one more unknown."""

    regressors: Regressors
    wheels: Wheels
    known: KnownMomentum | None
    nominal: Float[np.ndarray, " pi"]
    integrated: bool
    """Whether the base rate is a derivative, whose noise is white once integrated."""

    def fit(
        self,
        samples: Samples,
        rates: Float[np.ndarray, "n rates"],
        pi: Float[np.ndarray, " pi"],
    ) -> _Round:
        """`pi` and a small change of the delay together."""
        table, seen = self._table(samples, rates, pi)
        axes = table.shape[1]
        layout = momentum_layout(self.regressors, self.known, pi.size + 1)
        if self.integrated:
            # From an unknown start.
            start = np.broadcast_to(np.eye(axes), (seen.sum(), axes, axes))
            table = cumulative_trapezoid(
                table[seen], samples.t[seen], axis=0, initial=0
            )
            table = np.concatenate([start, table], axis=2)
            layout = layout._replace(nuisances=layout.nuisances + axes)
        rows = table.reshape(-1, layout.columns)
        R = np.linalg.qr(rows, mode="r")
        place, count = layout.nuisances + pi.size, int(seen.sum()) * axes
        prior = self._prior(layout, abs(float(R[-1, -1])) / np.sqrt(count))
        R = np.linalg.qr(np.concatenate([R, prior]), mode="r")
        fit = solve(R, layout, count + pi.size)
        return _Round(
            change=float(fit.values[-1]),
            std=_std(rows, R, place, fit),
            pi=fit.values[:-1],
            before=float(np.hypot(fit.unexplained, R[place, -1])),
            after=fit.unexplained,
        )

    def _table(
        self, samples: Samples, rates: np.ndarray, pi: np.ndarray
    ) -> tuple[Float[np.ndarray, "n axes columns"], Bool[np.ndarray, " n"]]:
        """All rows with the delay's column, and which samples count."""
        n, axes = samples.t.size, len(self.regressors.momentum_axes)
        layout = momentum_layout(self.regressors, self.known, pi.size)
        tables, seen = [], []
        for k, batch in enumerate(samples.batches(BATCH)):
            now = np.zeros((BATCH, rates.shape[1]))
            here = rates[k * BATCH : (k + 1) * BATCH]
            now[: len(here)] = np.nan_to_num(here)
            rows, _ = rows_of(self.regressors, self.wheels, self.known, batch, False)
            shift = _shift(self.regressors, self.wheels, batch, now, pi)
            place = layout.nuisances + pi.size
            tables.append(np.insert(np.asarray(rows), place, np.asarray(shift), axis=1))
            seen.append(batch.turning)
        table = np.concatenate(tables).reshape(-1, axes, layout.columns + 1)
        return table[:n], np.concatenate(seen)[:n]

    def _prior(self, layout: Layout, rms: float) -> Float[np.ndarray, "pi columns"]:
        """`pi` near its nominal value, one equation each, as sure as the residual."""
        pis = self.nominal.size
        size = np.maximum(np.abs(self.nominal), np.median(np.abs(self.nominal)))
        weight = rms / (NOMINAL * size)
        rows = np.zeros((pis, layout.columns))
        rows[:, layout.nuisances : layout.nuisances + pis] = np.diag(weight)
        rows[:, -1] = weight * self.nominal
        return rows


def _std(
    rows: Float[np.ndarray, "rows columns"],
    R: Float[np.ndarray, "columns columns"],
    place: int,
    fit: LinearFit,
) -> float:
    """Of the unknown at `place`, where residuals resemble their neighbours.

    With `g` what is left of its column once the others are projected out, an estimate
    is off by `g.r / g.g`: the variance of `g.r` is taken from its parts over stretches
    much longer than what residuals remember (cluster-robust, Liang and Zeger 1986).
    """
    others = np.linalg.lstsq(R[:place, :place], R[:place, place], rcond=None)[0]
    g = rows[:, place] - rows[:, :place] @ others
    x = np.concatenate([fit.nuisances, fit.values])
    residual = rows[:, -1] - rows[:, : x.size] @ x
    parts = [part.sum() for part in np.array_split(g * residual, STRETCHES)]
    return float(np.linalg.norm(parts) / R[place, place] ** 2)


@jax.jit
def _shift(
    regressors: Regressors,
    wheels: Wheels,
    batch: Batch,
    rates: Float[AnyArray, "n rates"],
    pi: Float[AnyArray, " pi"],
) -> Float[AnyArray, " rows"]:
    """`d/dt (Y pi + A_rw qd_rw)` by joints and wheels alone."""
    joints = batch.q.shape[1]

    def shift(sample: Batch, rate: Float[AnyArray, " rates"]) -> AnyArray:
        def h(q, qd):
            return regressors(q, qd, sample.w)[0] @ pi

        qdd, qdd_rw = rate[:joints], rate[joints:]
        _, change = jax.jvp(h, (sample.q, sample.qd), (sample.qd, qdd))
        change += (wheels.A_rw @ qdd_rw)[regressors.momentum_axes,]
        return jnp.where(sample.turning, change, 0.0)

    return jax.vmap(shift)(batch, rates).ravel()
