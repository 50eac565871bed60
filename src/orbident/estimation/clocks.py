"""Whether the clock of joints and wheels agrees with that of the base's sensors.

The delay is found by Gauss-Newton: an equation that is linear in a small delay
(`orbident.estimation.clocks`), again and again with joints moved by what was
found.

The momentum equation with a delay of joints and wheels as one more unknown.

Joints seen too late predict a base that turns too late. With `l` the delay, to first
order,

    Y pi + l d/dt|_joints (Y pi + A_rw qd_rw) - R_0^T h_cm = -A_rw qd_rw

where the derivative is that of joints and wheels alone, the base held.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.interpolate import CubicSpline

from orbident.estimation.linear_fits import (
    BATCH,
    InitialMomentum,
    KnownMomentum,
    known_momentum,
    momentum_layout,
    rows_of,
)
from orbident.estimation.triangular import Layout
from orbident.model.minimal_sets import MinimalSets, Regressors
from orbident.model.wheel_arrays import Wheels, wheels_of
from orbident.preprocessing.attitude_delay import attitude_delay
from orbident.preprocessing.base_motion import AXES as GYRO
from orbident.preprocessing.base_motion import QUATERNION as ATTITUDE
from orbident.preprocessing.base_motion import SMOOTHED
from orbident.preprocessing.delays import SETTLED, WORTH, Delay, delay_of, delays
from orbident.preprocessing.samples import Batch, Samples
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot

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


NUMBERS = 2**20
"""Most numbers in all equations; the middle of a longer recording is enough."""

MOST = 2**13
"""Samples."""

STEP = 0.02
"""s: joints move little meanwhile. A short stretch of samples that follow each other
faster would show hardly any motion, and that could be anything's."""

GAP = 10.0
"""Times the usual step from sample to sample."""

LONGEST = 0.25
"""Longest delay, over the duration of the stretch that is looked at: a search that goes
beyond has lost its way, and too little would be left for both clocks to show."""

ROUNDS = 8

FEWEST = 4
"""Complete samples that a cubic spline of the joints needs."""


def base_clocks(robot: Robot, recording: Recording) -> dict[str, Delay]:
    """That of the attitude against the gyro's, where there are both.

    What the robot file declares as latency is no error of a clock.
    """
    if not recording.has(*GYRO, *ATTITUDE):
        return {}
    seen = _seen([recording.column(name) for name in GYRO])
    rows = _middle(seen & _unbroken(recording.t, seen), MOST)
    w, fixes = (
        np.column_stack([recording.column(name)[rows] for name in names])
        for names in (GYRO, ATTITUDE)
    )
    declared = delays(robot, recording, {})["attitude"]
    delay = attitude_delay(recording.t[rows], w, fixes, declared)
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
    part = _part(samples, len(sets.pi(robot.theta)))
    if _seen([*part.q, *part.qd, *part.qd_rw]).sum() < FEWEST:
        return {}
    return {"joints": joint_delay(robot, sets, samples, initial_momentum)}


NAMES = {"joints": "joints and wheels", "attitude": "attitude and position"}
"""What shares a clock."""


def clocks_in_words(clocks: Mapping[str, Delay]) -> tuple[str, ...]:
    """What was corrected."""
    return tuple(
        f"the clock of {NAMES[sensor]} is {1e3 * delay.late:.2f} +- "
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
    equations = DelayEquations(sets.regressors, wheels_of(robot), known, pi, derived)
    part = _part(samples, pi.size)
    moving = MovingJoints.of(part)
    found = equations.fit(*moving.at(0.0), pi)
    late, before = found.change, found.before
    longest = LONGEST * np.ptp(part.t)
    # Where no delay makes the fit better there is nothing to settle.
    for _ in range(ROUNDS if found.after**2 < WORTH * found.before**2 else 0):
        if abs(found.change) < max(SETTLED, found.std / 10) or abs(late) > longest:
            break
        found = equations.fit(*moving.at(late), found.pi)
        late += found.change
    if abs(late) > longest:
        return Delay(late, found.std, believed=False)
    return delay_of(late, found.std, found.change, before, found.after)


def _part(samples: Samples, unknowns: int) -> Samples:
    """As much of the middle as there is room for the equations of."""
    axes = len(samples.w)
    seen = np.flatnonzero(_seen(samples.w))
    fast = float(np.median(np.diff(samples.t[seen]))) if seen.size > 1 else STEP
    seen = seen[:: max(int(STEP / fast), 1)]
    rows = seen[_inner(seen.size, min(MOST, NUMBERS // (axes * unknowns)))]
    names = ("q", "qd", "w", "x_WB", "qd_rw")
    parts = {
        name: tuple(column[rows] for column in getattr(samples, name)) for name in names
    }
    return replace(samples, t=samples.t[rows], v_S=(), **parts)


def _seen(columns: Sequence[Float[np.ndarray, " n"]]) -> Bool[np.ndarray, " n"]:
    """Rows on which all have a sample."""
    return np.logical_and.reduce([~np.isnan(column) for column in columns])


def _unbroken(
    t: Float[np.ndarray, " n"], seen: Bool[np.ndarray, " n"]
) -> Bool[np.ndarray, " n"]:
    """The longest stretch without a gap that integration cannot bridge."""
    if not seen.any():
        return seen
    steps = np.diff(t[seen], prepend=t[seen][0])
    stretch = np.cumsum(steps > GAP * np.median(steps))
    longest = np.zeros_like(seen)
    longest[seen] = stretch == np.argmax(np.bincount(stretch))
    return longest


def _middle(seen: Bool[np.ndarray, " n"], most: int) -> slice:
    """Rows in the middle, of which at most so many are seen."""
    rows = np.flatnonzero(seen)
    inner = rows[_inner(rows.size, most)]
    return slice(inner[0], inner[-1] + 1) if inner.size else np.s_[:]


def _inner(count: int, most: int) -> slice:
    start = max(count - most, 0) // 2
    return slice(start, start + most)
