"""The momentum equation with a delay of joints and wheels as one more unknown.

Joints seen too late predict a base that turns too late. With `l` the delay, to first
order,

    Y pi + l d/dt|_joints (Y pi + A_rw qd_rw) - R_0^T h_cm = -A_rw qd_rw

where the derivative is that of joints and wheels alone, the base held.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.interpolate import CubicSpline

from orbident.estimation.linear_fits import (
    BATCH,
    KnownMomentum,
    momentum_layout,
    rows_of,
)
from orbident.estimation.triangular import Layout
from orbident.model.minimal_sets import Regressors
from orbident.model.wheel_arrays import Wheels
from orbident.preprocessing.samples import Batch, Samples

STRETCHES = 20
"""Number of stretches of a recording; each is taken to err for itself."""

NOMINAL = 0.3
"""Std of `pi` about its nominal value, over its size."""


class MovingJoints(NamedTuple):
    """Joints and wheels of some samples as functions of time."""

    samples: Samples
    history: CubicSpline
    """Spline of `[q, qd, qd_rw]` over time."""

    @classmethod
    def of(cls, samples: Samples) -> "MovingJoints":
        """Joints that move along cubic splines through the samples."""
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


class DelayFit(NamedTuple):
    """`pi` and a change of the delay, estimated together."""

    change: float
    """s."""
    std: float
    """s."""
    pi: Float[np.ndarray, " pi"]
    before: float
    """Norm of the residual without a change of the delay."""
    after: float


class DelayEquations(NamedTuple):
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
    ) -> DelayFit:
        """`pi` and a small change of the delay together."""
        table, seen = self._table(samples, rates, pi)
        axes = table.shape[1]
        layout = momentum_layout(self.regressors, self.known, pi.size + 1)
        if self.integrated:
            # From an unknown start.
            start = np.broadcast_to(np.eye(axes), (seen.sum(), axes, axes))
            # By the trapezoidal rule.
            dt = np.diff(samples.t[seen])[:, None, None]
            steps = dt * (table[seen][1:] + table[seen][:-1]) / 2
            table = np.cumsum(np.insert(steps, 0, 0.0, axis=0), axis=0)
            table = np.concatenate([start, table], axis=2)
            layout = layout._replace(nuisances=layout.nuisances + axes)
        rows = table.reshape(-1, layout.columns)
        R = np.asarray(np.linalg.qr(rows, mode="r"))
        place, count = layout.nuisances + pi.size, int(seen.sum()) * axes
        prior = self._prior(layout, abs(float(R[-1, -1])) / np.sqrt(count))
        R = np.asarray(np.linalg.qr(np.concatenate([R, prior]), mode="r"))
        x = _solution(R[: place + 1, : place + 1], R[: place + 1, -1])
        after = np.linalg.norm(R[place + 1 :, -1])
        return DelayFit(
            change=float(x[place]),
            std=_std(rows, R, x),
            pi=x[layout.nuisances : place],
            before=float(np.hypot(after, R[place, -1])),
            after=float(after),
        )

    def _table(
        self, samples: Samples, rates: np.ndarray, pi: np.ndarray
    ) -> tuple[Float[np.ndarray, "n axes columns"], Bool[np.ndarray, " n"]]:
        """All rows with the delay's column, and which samples count."""
        axes = len(self.regressors.momentum_axes)
        layout = momentum_layout(self.regressors, self.known, pi.size)
        tables, seen = [], []
        for k, batch in enumerate(samples.batches(BATCH)):
            now = np.nan_to_num(rates[k * BATCH : (k + 1) * BATCH])
            rows, _ = rows_of(self.regressors, self.wheels, self.known, batch, None)
            shift = _shift(self.regressors, self.wheels, batch, now, pi)
            place = layout.nuisances + pi.size
            tables.append(np.insert(rows, place, shift, axis=1))
            seen.append(batch.turning)
        table = np.concatenate(tables).reshape(-1, axes, layout.columns + 1)
        return table, np.concatenate(seen)

    def _prior(self, layout: Layout, rms: float) -> Float[np.ndarray, "pi columns"]:
        """`pi` near its nominal value, one equation each, as sure as the residual."""
        pis = self.nominal.size
        size = np.maximum(np.abs(self.nominal), np.median(np.abs(self.nominal)))
        weight = rms / (NOMINAL * size)
        rows = np.zeros((pis, layout.columns))
        rows[:, layout.nuisances : layout.nuisances + pis] = np.diag(weight)
        rows[:, -1] = weight * self.nominal
        return rows


def _solution(
    R: Float[np.ndarray, "n n"], z: Float[np.ndarray, " n"]
) -> Float[np.ndarray, " n"]:
    """The solution of `R x = z`; the shortest where the motion leaves parts open."""
    return np.linalg.lstsq(R, z, rcond=None)[0]


def _std(
    rows: Float[np.ndarray, "rows columns"],
    R: Float[np.ndarray, "columns columns"],
    x: Float[np.ndarray, " unknowns"],
) -> float:
    """Deviation of the last unknown, where residuals resemble their neighbours.

    With `g` what is left of its column once the others are projected out, an estimate
    is off by `g.r / g.g`: the variance of `g.r` is taken from its parts over stretches
    much longer than what residuals remember (cluster-robust, Liang and Zeger 1986).
    """
    place = x.size - 1
    others = _solution(R[:place, :place], R[:place, place])
    g = rows[:, place] - rows[:, :place] @ others
    residual = rows[:, -1] - rows[:, : x.size] @ x
    parts = [part.sum() for part in np.array_split(g * residual, STRETCHES)]
    return float(np.linalg.norm(parts) / R[place, place] ** 2)


def _shift(
    regressors: Regressors,
    wheels: Wheels,
    batch: Batch,
    rates: Float[np.ndarray, "n rates"],
    pi: Float[np.ndarray, " pi"],
) -> Float[np.ndarray, " rows"]:
    """`d/dt (Y pi + A_rw qd_rw)` by joints and wheels alone."""
    joints = batch.q.shape[1]
    qdd, qdd_rw = rates[:, :joints], rates[:, joints:]
    change = regressors.momentum_rate((batch.q, batch.qd, qdd), batch.w, pi)
    change += (qdd_rw @ wheels.A_rw.T)[:, regressors.momentum_axes]
    change[~batch.turning] = 0.0
    return change.ravel()
