"""A recording cut into shooting intervals: its rows, and what joints and wheels did."""

from itertools import chain
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int
from scipy.interpolate import CubicHermiteSpline, CubicSpline

from orbident.estimation.output_error.joint_laws import LOOSE, fastest
from orbident.estimation.output_error.sensors import (
    Sensors,
    some_of,
)
from orbident.model.kinematics import inertia_at, principal_inertias
from orbident.preprocessing.histories import Columns
from orbident.preprocessing.samples import Samples, wheels_momentum
from orbident.robot.description import Robot

SHORT, LONG = 4, 128
"""Samples of the joints in an interval, and at least so many rows."""

PASSED_ON = 5.0
"""Times its own noise that a sensor of the base may show of that of smoothed encoders.
Of it corrections leave a tenth, as cubics do through points half a period apart."""

OF_THE_BASE = ("attitude", "gyro", "position", "velocity")
"""Sensors that show how the base turns and moves, angles and lengths before rates."""

HALVED = 2.0**4
"""Times less is left by intervals half as long: so it is by cubics."""

OF_A_RADIAN = 0.75
"""An interval lasts so much of a radian of the joints' motion: cubics follow that."""

STEP = 1 / 16
"""rad of nutation: steps of RK4 so large are wrong by 1e-8 rad."""

SWING = 1 / 6
"""rad of a passive joint whose base is held: where it swings twice as fast, as the base
is free, steps of RK4 so large change its frequency by 1e-4."""

MOST_SUBSTEPS = 32
"""Between two samples: enough for a nutation of 2 rad."""


class JointHistory(NamedTuple):
    """Joints and wheels between their samples, by cubic splines; a column each."""

    t: Float[np.ndarray, " knots"]
    """s."""
    q: Columns
    q_slope: Columns
    """Slopes of the spline through positions: rates are splines of their own."""
    qd: Columns
    qdd: Columns
    qd_rw: Columns
    """rad/s."""
    qdd_rw: Columns
    """rad/s^2."""

    def at(
        self, columns: Columns, slopes: Columns, t: Float[np.ndarray, " n"]
    ) -> Float[np.ndarray, "n columns"]:
        """Some of its columns, which have these slopes, at other times."""
        values = np.empty((t.size, len(columns)))
        for k, (x, slope) in enumerate(zip(columns, slopes, strict=True)):
            values[:, k] = CubicHermiteSpline(self.t, x, slope)(t)
        return values


class Intervals(NamedTuple):
    """The rows that count, and where intervals begin."""

    samples: Samples
    """The histories of joints and wheels that are cut."""
    kept: slice
    """Which of the sensors' rows: joints and wheels are known there."""
    t: Float[np.ndarray, " rows"]
    """s."""
    edges: Int[np.ndarray, " boundaries"]
    """The first row of each interval, and the number of rows."""
    history: JointHistory

    @property
    def boundaries(self) -> Float[np.ndarray, " boundaries"]:
        """The times at which intervals begin, and at which the last one ends, s."""
        return self.t[np.minimum(self.edges, self.t.size - 1)]


def intervals_of(
    robot: Robot,
    samples: Samples,
    sensors: Sensors,
    longest: float = np.inf,
    like: Intervals | None = None,
) -> Intervals:
    """Cut a recording into intervals that cubics follow.

    Args:
        robot: its nominal inertia says what noise of encoders does to the base.
        samples: histories of joints and wheels.
        sensors: with the times that count.
        longest: no interval is longer, s.
        like: those of a recording that differs little: it is cut as they are.
    """
    same = like and samples is like.samples
    history = like.history if like and same else _history(samples)
    ends = history.t[0], np.nextafter(history.t[-1], np.inf)
    first, end = (int(row) for row in np.searchsorted(sensors.t, ends))
    t = sensors.t[first:end]
    kept = slice(first, end)
    if like and np.array_equal(t, like.t):
        return Intervals(samples, kept, t, like.edges, history)
    a_sample = t.size / _samples_of_joints(sensors, kept)
    halvings = _halvings(robot, samples, sensors)
    rows = _rows_of_an_interval(history, samples.shares, t, a_sample, halvings)
    if samples.unknown_thrust:
        rows = min(rows, _rows_of_a_turn(samples))
    edges = _edges(t.size, rows)
    most = max(1.0, longest / float(np.median(np.diff(t))))
    parts = np.maximum(np.ceil(np.diff(edges) / most), 1).astype(int)
    finer = [
        np.linspace(start, stop, n, endpoint=False).round()
        for start, stop, n in zip(edges[:-1], edges[1:], parts, strict=True)
    ]
    edges = np.concatenate([*finer, edges[-1:]]).astype(int)
    return Intervals(samples, kept, t, edges, history)


def _history(samples: Samples) -> JointHistory:
    """Where all was measured."""
    columns = samples.q, samples.qd, samples.qd_rw
    known = np.ones(samples.t.size, dtype=bool)
    for column in chain(*columns):
        known &= np.isfinite(column)
    t = some_of(samples.t, known)
    q, qd, qd_rw = (tuple(some_of(x, known) for x in each) for each in columns)
    # One column after another: a spline has four numbers a sample.
    by_q, by_qd, by_qd_rw = (
        tuple(CubicSpline(t, x)(t, nu=1) for x in each) for each in (q, qd, qd_rw)
    )
    return JointHistory(t, q, by_q, qd, by_qd, qd_rw, by_qd_rw)


def _edges(samples: int, rows: int) -> Int[np.ndarray, " edges"]:
    """The first row of each interval, and the end.

    Smoothed joint histories are worst in the first and last few samples, where a gyro
    knows better: intervals are short there.
    """
    short = [2**k for k in range(1, rows.bit_length() - 1)]
    middle = samples - 2 * sum(short)
    if middle < rows:
        short, middle = [], samples
    count = -(-middle // rows)
    even = np.diff(np.round(np.linspace(0, middle, count + 1)).astype(int))
    return np.cumsum([0, *short, *even, *reversed(short)])


def _samples_of_joints(sensors: Sensors, kept: slice) -> int:
    """How often encoders showed something; every row where none is a sensor."""
    encoders = sensors.by_name.get("joints")
    values = np.zeros((0, 1)) if encoders is None else encoders.values[kept]
    return int(np.isfinite(values).any(axis=1).sum()) or sensors.t[kept].size


def _rows_of_an_interval(
    history: JointHistory,
    shares: tuple[float, ...],
    t: Float[np.ndarray, " rows"],
    a_sample: float,
    halvings: int,
) -> int:
    """A power of two: intervals at both ends are halved again and again.

    The variance of a smoothed sample over that of the noise is the number of unknowns
    that a sample determines. An interval has two unknowns of a joint, twice as many as
    that: what moves is rougher at times. From one sample of the joints to the next
    there are `a_sample` rows. Where that leaves too much it is halved, as long as there
    are twice as many samples as unknowns.
    """
    splines = [
        CubicHermiteSpline(history.t, x, slope)
        for x, slope in zip(history.qd, history.qdd, strict=True)
    ]
    rate, bend = (
        np.array([np.sqrt(np.mean(each(t, nu=nu) ** 2)) for each in splines])
        for nu in (0, 1)
    )
    moving = rate > 0
    if not moving.any():
        return LONG
    radian = float(np.min(rate[moving] / np.maximum(bend[moving], 1e-12)))
    smoothed = np.nanmax(np.array(shares)[moving], initial=1 / LONG)
    rows = min(
        OF_A_RADIAN * radian / float(np.median(np.diff(t))),
        a_sample * max(1 / smoothed / 2**halvings, SHORT),
    )
    return int(2 ** np.round(np.log2(max(rows, SHORT))))


def _halvings(robot: Robot, samples: Samples, sensors: Sensors) -> int:
    """How often an interval is halved, so that the base hardly shows encoders' noise.

    A smoothed position is off by `e`, up to half the frequency of its unknowns. That
    turns the base by `D^-1 D_q e` (Eq. 3), and S beside the CM moves by `J_cm e`.
    """
    encoders = sensors.by_name.get("joints")
    if encoders is None:
        return 0
    share = np.nan_to_num(np.array(samples.shares))
    e = encoders.std * np.sqrt(share)
    w = float(np.pi * share.max(initial=0.0) / np.median(np.diff(samples.t)))
    q = np.array([np.nanmean(x) if x.size else 0.0 for x in samples.q])
    at, (turning, moving) = inertia_at(robot, q), map(list, robot.conserved_axes)
    turns = np.linalg.solve(at.D[np.ix_(turning, turning)], at.D_q[turning])
    turned = float(np.max(np.linalg.norm(turns, axis=0) * e, initial=0.0))
    moved = float(np.max(np.linalg.norm(at.J_cm[moving], axis=0) * e, initial=0.0))
    shown = zip(OF_THE_BASE, (turned, turned * w, moved, moved * w), strict=True)
    sized = [size / sensors.by_name[x].std for x, size in shown if x in sensors.by_name]
    most = max(sized, default=0.0) / PASSED_ON
    return int(np.ceil(np.log(max(most, 1.0)) / np.log(HALVED)))


def _rows_of_a_turn(samples: Samples) -> int:
    """A power of two: in so many rows the base turns by `OF_A_RADIAN` at most.

    Where thrust is not what the first guess says, the base turns otherwise, faster and
    faster; by whole turns it would be lost.
    """
    turned = np.nanmax(np.linalg.norm(samples.w, axis=0), initial=0.0)
    rows = OF_A_RADIAN / max(turned * float(np.median(np.diff(samples.t))), 1e-12)
    return int(2 ** np.floor(np.log2(np.clip(rows, SHORT, LONG))))


def substeps_of(robot: Robot, samples: Samples, unexplained: float) -> int:
    """How many RK4 steps a sample follow nutation and passive joints; a power of two.

    Nutation turns with at most `|h_cm| / D`, and its phase is wrong by the fourth power
    of the step. So is that of a passive joint, of which more than in the last of the
    loose fits may be unexplained, rad or m in a period.
    """
    dt = float(np.median(np.diff(samples.t)))
    swung = 2 * np.pi * fastest(robot) * dt
    swing = SWING * max(unexplained / LOOSE[-1], 1.0) ** (1 / 4)
    least = int(2 ** np.ceil(np.log2(np.clip(swung / swing, 1, MOST_SUBSTEPS))))
    if robot.motion == "planar":
        return least
    D = principal_inertias(robot)
    w, h_rw = (
        np.nanmax(np.linalg.norm(vectors, axis=1), initial=0.0)
        for vectors in (np.column_stack(samples.w), wheels_momentum(robot, samples))
    )
    rate = w + (D[-1] * w + h_rw) / D[0]
    turned = rate * dt
    return max(
        least, int(2 ** np.ceil(np.log2(np.clip(turned / STEP, 1, MOST_SUBSTEPS))))
    )
