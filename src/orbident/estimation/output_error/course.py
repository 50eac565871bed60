"""A recording cut into segments: what joints and wheels did, what sensors showed."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.interpolate import CubicSpline

from orbident.dynamics.wheels import wheels_of
from orbident.estimation.output_error.segment import Course, Shown
from orbident.estimation.output_error.sensors import Sensors
from orbident.estimation.output_error.terms import JointState
from orbident.robot.description import Robot
from orbident.signals.samples import Samples
from orbident.signals.smoothing import smooth

BATCH = 8
"""Segments that are linearised at once."""

SHORT, LONG = 4, 128
"""Rows of a segment."""

ENOUGH = 4096
"""Samples that tell how smooth the joints move."""

OF_A_RADIAN = 0.75
"""A segment lasts so much of a radian of the joints' motion: cubics follow that."""


class Chart(NamedTuple):
    """All segments, stacked, and the times between them."""

    course: Course
    shown: Shown
    t: Float[np.ndarray, " segments+1"]
    """Where they begin, and where the last one ends, s."""


def chart_of(robot: Robot, samples: Samples, sensors: Sensors) -> Chart:
    """Cut into segments, padded to whole batches."""
    history = _History.of(robot, samples)
    inside = (sensors.t >= history.start) & (sensors.t <= history.end)
    t = sensors.t[inside]
    edges = _edges(t.size, _rows_of_a_segment(history, sensors, t))
    rows = int(np.diff(edges).max())
    padded = -(-(edges.size - 1) // BATCH) * BATCH
    edges = np.append(edges, np.full(padded + 1 - edges.size, t.size))
    # Where a segment is shorter, rows that take no time fill it up.
    at = edges[:-1, None] + np.arange(rows + 1)
    real = (at[:, :-1] < edges[1:, None]).ravel()
    at = np.minimum(np.minimum(at, edges[1:, None]), t.size - 1)
    dt = np.diff(t[at])
    half_way = t[at[:, :-1]][..., None] + dt[..., None] * np.array([0.0, 0.5])
    starts = np.append(t[at[:, 0]], t[-1])
    nodes = np.hstack([half_way.reshape(padded, -1), starts[1:, None]])
    joints, h_rw, h_rw_rate = history.at(nodes)
    course = Course(
        joints=joints,
        h_rw=h_rw,
        h_rw_rate=h_rw_rate,
        basis=_hermite(nodes, starts),
        t=nodes - t[0],
        dt=dt,
    )
    values, weights = {}, {}
    for name, sensed in sensors.by_name.items():
        table = sensed.values[inside][at[:, :-1].ravel()]
        seen = np.isfinite(table).all(axis=1) & real
        if name == "accelerometer":
            seen &= dt.ravel() > 0
        axes = 3 if name == "attitude" else table.shape[1]
        blank = np.array([0, 0, 0, 1.0]) if name == "attitude" else 0.0
        values[name] = np.where(seen[:, None], table, blank).reshape(padded, rows, -1)
        weight = np.where(seen[:, None], 1 / sensed.std, 0.0) * _axes(robot, name, axes)
        weights[name] = weight.reshape(padded, rows, axes)
    return Chart(course, Shown(values, weights), starts)


def _edges(samples: int, rows: int) -> Int[np.ndarray, " edges"]:
    """The first row of each segment, and the end.

    Smoothed joint histories are worst in the first and last few samples, where a gyro
    knows better: segments are short there.
    """
    short = [2**k for k in range(1, rows.bit_length() - 1)]
    middle = samples - 2 * sum(short)
    if middle < rows:
        short, middle = [], samples
    count = -(-middle // rows)
    even = np.diff(np.round(np.linspace(0, middle, count + 1)).astype(int))
    return np.cumsum([0, *short, *even, *reversed(short)])


def _axes(robot: Robot, sensor: str, axes: int) -> Float[np.ndarray, " axes"]:
    """1 for those in which momentum is conserved; encoders have all."""
    if robot.motion != "planar" or sensor == "joints":
        return np.ones(axes)
    turning = sensor in {"gyro", "attitude"}
    return np.array([0.0, 0.0, 1.0] if turning else [1.0, 1.0, 0.0])


class _History(NamedTuple):
    """Joints and wheels at any time."""

    spline: CubicSpline
    """Of `q`, `qd` and the wheels' momentum."""
    joints: int
    start: float
    end: float

    @classmethod
    def of(cls, robot: Robot, samples: Samples) -> "_History":
        table = np.column_stack([*samples.q, *samples.qd, *samples.qd_rw])
        known = np.isfinite(table).all(axis=1)
        n = 2 * len(robot.joints)
        h_rw = table[known, n:] @ wheels_of(robot).A_rw.T
        t = samples.t[known]
        both = np.hstack([table[known, :n], h_rw])
        return cls(CubicSpline(t, both), len(robot.joints), t[0], t[-1])

    def at(
        self, t: Float[np.ndarray, "*n"]
    ) -> tuple[JointState, Float[np.ndarray, "*n 3"], Float[np.ndarray, "*n 3"]]:
        q, qd, h_rw = np.split(self.spline(t), [self.joints, 2 * self.joints], axis=-1)
        rates = self.spline(t, nu=1)[..., self.joints :]
        qdd, h_rw_rate = np.split(rates, [self.joints], axis=-1)
        return JointState(q, qd, qdd), h_rw, h_rw_rate


def _rows_of_a_segment(
    history: _History, sensors: Sensors, t: Float[np.ndarray, " rows"]
) -> int:
    """A power of two: few sizes are compiled."""
    joints, _, _ = history.at(t)
    rate, bend = (np.sqrt(np.mean(x**2, axis=0)) for x in (joints.qd, joints.qdd))
    moving = rate > 0
    if not moving.any():
        return LONG
    radian = float(np.min(rate[moving] / np.maximum(bend[moving], 1e-12)))
    lasting = OF_A_RADIAN * radian
    if "joints" in sensors.by_name:
        lasting = min(lasting, _as_smooth_as(sensors, moving))
    rows = lasting / float(np.median(np.diff(t)))
    return int(2 ** np.round(np.log2(np.clip(rows, SHORT, LONG))))


def _as_smooth_as(sensors: Sensors, moving: Bool[np.ndarray, " joints"]) -> float:
    """How long a segment may last for its cubics to follow what smoothing leaves, s.

    A smoothed sample's variance, over that of the noise, is the number of unknowns a
    sample that smoothing is worth. A segment has two of a joint, and there are twice
    as many: what moves is rougher at times.
    """
    encoders = sensors.by_name["joints"]
    seen = np.flatnonzero(np.isfinite(encoders.values).all(axis=1))
    middle = seen[max(seen.size - ENOUGH, 0) // 2 :][:ENOUGH]
    t, x = sensors.t[middle], encoders.values[middle][:, moving]
    found = smooth(t, x, encoders.std, name="joints")
    variance = np.median(np.square(found.std_x), axis=0) / encoders.std**2
    return 1 / float(variance.max()) * float(np.median(np.diff(t)))


def _hermite(
    nodes: Float[np.ndarray, "s nodes"], starts: Float[np.ndarray, " s+1"]
) -> Float[np.ndarray, "s nodes 3 4"]:
    """Cubic Hermite functions of `[x_0, v_0, x_1, v_1]`, with two derivatives."""
    T = np.diff(starts)[:, None]
    T = np.where(T > 0, T, 1.0)
    s = (nodes - starts[:-1, None]) / T
    value = [1 - 3 * s**2 + 2 * s**3, T * (s - 2 * s**2 + s**3)]
    value += [3 * s**2 - 2 * s**3, T * (s**3 - s**2)]
    rate = [6 * (s**2 - s) / T, 1 - 4 * s + 3 * s**2]
    rate += [6 * (s - s**2) / T, 3 * s**2 - 2 * s]
    bend = [(12 * s - 6) / T**2, (6 * s - 4) / T]
    bend += [(6 - 12 * s) / T**2, (6 * s - 2) / T]
    return np.stack([np.stack(x, axis=-1) for x in (value, rate, bend)], axis=-2)
