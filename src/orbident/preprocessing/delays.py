"""How much each sensor's times are behind those of the base rate.

A fix of the attitude with the time `t` that shows the world of `t - l` is, to first
order, turned back by `l w`; seen from inertial axes, beside the gyro's own error,

    log(R_fix R^T) = phi_0 - (integral of R^) b - (integral of R^ E w) - l R^ w,

with `R^` by the gyro alone: linear in the start `phi_0`, the gyro's bias `b`, its scale
and misalignment `E`, which would pass for a delay, and the delay `l`. It is repeated
with what was found.
"""

from collections.abc import Mapping
from typing import Annotated, NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from pydantic import Field
from scipy.interpolate import CubicSpline
from scipy.optimize import fminbound
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from orbident.errors import InputError
from orbident.files.json_parts import NullableNumber, NullableStd
from orbident.preprocessing.integrals import (
    gyro_response,
    integrate_gyro,
    start_of_gyro,
)
from orbident.recordings.columns import vector_columns
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot

LEAST = 1e-4
"""s: smaller delays do not matter, and need not be corrected."""

SURE = 5.0
"""Standard deviations that a delay must have."""

WORTH = 0.9
"""A delay is believed where it makes the squared residual smaller than this times."""

LONGEST = 1.0
"""s: sensors, buses and cameras are late by tenths of a second. Clocks that are further
apart were never set together; such clocks drift too, and no constant corrects that."""

EXPLAINED = 0.1
"""A delay that is refused must be what is wrong: it leaves so little of the squared
residual. The last round of its search changed it by so little of itself."""

SETTLED = 1e-6
"""s: changes of the last round below this are none."""

COUNTS = {"ms": 1e3, "us": 1e6, "ns": 1e9}
"""What loggers count time in, and how many of it a second has."""

DECLARED = 0.2
"""Part by which the rate of a recording may miss the declared one."""


class Delay(NamedTuple):
    """How much the times of a sensor are behind those of the base rate."""

    late: NullableNumber
    """s."""
    std: NullableStd
    believed: Annotated[bool, Field(strict=True, alias="corrected")]
    """Whether it is more than chance, matters, and is short enough to be corrected."""
    apart: Annotated[bool, Field(exclude=True)] = False
    """Whether it is certain, but longer than any sensor is late."""


def delay_of(
    late: float, std: float, change: float, before: float, after: float
) -> Delay:
    """What an iteration found, and whether to believe it.

    Args:
        late: the delay, s.
        std: its standard deviation, s.
        change: of the delay in the last round, s.
        before: norm of the residual without a delay.
        after: with it.
    """
    settled = abs(change) < max(SETTLED, std)
    matters = abs(late) > max(LEAST, SURE * std)
    better = after**2 < WORTH * before**2
    if abs(late) > LONGEST:
        # Near enough to be named.
        near = abs(change) < EXPLAINED * abs(late)
        apart = near and matters and after**2 < EXPLAINED * before**2
        return Delay(float(late), float(std), False, bool(apart))
    return Delay(float(late), float(std), bool(settled and matters and better))


SENSORS = (
    *("joints", "wheels", "torques"),
    *("gyro", "accelerometer", "attitude", "position"),
)


def delays(
    robot: Robot, recording: Recording, found: Mapping[str, float]
) -> dict[str, float]:
    """Declared latencies and what was found beside them, s.

    A sample with the time `t` shows the world as it was at `t - delay`, on the clock of
    the gyro; without a gyro on that of the attitude.

    Args:
        robot: whose file declares latencies.
        recording: which sensors there are.
        found: by sensor, on top of the declared latencies.
    """
    total = {
        sensor: (robot.sensors.of(sensor).latency or 0.0) + found.get(sensor, 0.0)
        for sensor in SENSORS
    }
    reference = total["gyro" if recording.has("gyro.x") else "attitude"]
    return {sensor: delay - reference for sensor, delay in total.items()}


def corrections(clocks: Mapping[str, Delay]) -> dict[str, float]:
    """The delays that are believed, s, by sensor; what shares a clock shares them.

    Args:
        clocks: of `"joints"` (and wheels) and of `"attitude"` (and position); those of
            one of several recordings say nothing of another.
    """
    shared = {
        "joints": ("joints", "wheels", "torques"),
        "attitude": ("attitude", "position"),
    }
    return {
        sensor: clocks[name].late
        for name, sensors in shared.items()
        if name in clocks and clocks[name].believed
        for sensor in sensors
    }


UNKNOWNS = 16
"""Start, bias, scale and misalignment, and the delay."""

FEWEST = 16
"""Samples of either sensor."""

ROUNDS = 8
LEAST_CHANGE = 1e-7
"""s: rounds that change a delay by less are the last."""


def attitude_delay(
    t: Float[np.ndarray, " n"],
    w: Float[np.ndarray, "n 3"],
    fixes: Float[np.ndarray, "n 4"],
    declared: float = 0.0,
) -> Delay | None:
    """How much the times of attitude fixes are behind the gyro's.

    Args:
        t: times, s.
        w: the gyro's samples, base axes, rad/s; NaN where there is none.
        fixes: attitudes from outside, unit quaternions; NaN where there is none.
        declared: by how much they are known to be behind, s.

    Returns:
        What is beyond the declared delay; None where too few fixes are there to tell.
    """
    measured = np.isfinite(w).all(axis=1)
    fixed = np.asarray(np.isfinite(fixes).all(axis=1))
    if measured.sum() < FEWEST or (measured & fixed).sum() < FEWEST:
        return None
    rate = CubicSpline(t[measured], w[measured], extrapolate=False)
    start, bias, late = start_of_gyro(t, w, fixes, fixed), np.zeros(3), declared
    found = before = None
    for _ in range(ROUNDS):
        x = integrate_gyro(t, w - bias, start)
        known = np.isfinite(x).all(axis=1)
        then = t - late
        if not known.any():
            return None
        usable = fixed & (t[known][0] <= then) & (then <= t[known][-1])
        if usable.sum() < FEWEST:
            return None
        R_then = Rotation.from_quat(CubicSpline(t[known], x[known])(then[usable]))
        error = Rotation.from_quat(fixes[usable]) * R_then.inv()
        gyro = gyro_response(t[known], x[known], rate(t[known]) - bias)
        B = CubicSpline(t[known], gyro)(then[usable])
        w_then = R_then.apply(rate(then[usable]) - bias)
        found = _solve(error.as_rotvec(), B, w_then)
        before = found.before if before is None else before
        late, bias = late + found.change, bias + found.bias
        start = (Rotation.from_rotvec(found.phi) * Rotation.from_quat(start)).as_quat()
        if abs(found.change) < max(LEAST_CHANGE, found.std / 10):
            break
    if found is None or before is None:
        return None
    return delay_of(late - declared, found.std, found.change, before, found.after)


class _DelayStep(NamedTuple):
    change: float
    std: float
    phi: Float[np.ndarray, "3"]
    bias: Float[np.ndarray, "3"]
    before: float
    """Norm of the residual without a change of the delay."""
    after: float


def _solve(
    y: Float[np.ndarray, "m 3"],
    B: Float[np.ndarray, "m 3 12"],
    w_then: Float[np.ndarray, "m 3"],
) -> _DelayStep:
    start = np.broadcast_to(np.eye(3), (len(y), 3, 3))
    by_axis = np.concatenate([start, -B, -w_then[:, :, None]], axis=2)
    A = by_axis.reshape(-1, UNKNOWNS)
    R = np.asarray(np.linalg.qr(np.column_stack([A, y.ravel()]), mode="r"))
    solution = np.linalg.lstsq(R[:-1, :-1], R[:-1, -1], rcond=None)[0]
    after, own = abs(float(R[-1, -1])), float(R[-2, -2])
    std = np.inf
    if own:
        # The delay is the last unknown: so much of each residual is in it.
        last = np.linalg.lstsq(R[:-1, :-1], np.eye(UNKNOWNS)[-1] / own, rcond=None)[0]
        std = _walked(y - by_axis @ solution, by_axis @ last)
    return _DelayStep(
        change=float(solution[-1]),
        std=std,
        phi=solution[:3],
        bias=solution[3:6],
        before=float(np.hypot(after, R[-2, -1])),
        after=after,
    )


def _walked(left: Float[np.ndarray, "m 3"], shares: Float[np.ndarray, "m 3"]) -> float:
    """The deviation of a sum of shares of residuals that are white and walk.

    Their changes are a moving average of innovations, `e(k) - a e(k-1)`: white noise of
    the variance `a var(e)`, and steps of a walk of `(1 - a)^2 var(e)`.
    """
    steps = np.diff(left, axis=0, prepend=0)

    def size(a: float) -> float:
        return float(np.sum(np.asarray(lfilter([1.0], [1.0, -a], steps, axis=0)) ** 2))

    a = min(1.0, float(np.array(fminbound(size, 0.0, 1.0))), key=size)
    later = np.cumsum(shares[::-1], axis=0)
    variance = size(a) / (left.size - UNKNOWNS)
    return float(
        np.sqrt(variance * (a * np.sum(shares**2) + (1 - a) ** 2 * np.sum(later**2)))
    )


MOST = 2**13
"""Samples; the middle of a longer recording is enough."""

GAP = 10.0
"""Times the usual step from sample to sample."""


def check_seconds(robot: Robot, recording: Recording) -> None:
    """Refuse times whose steps are those of the declared rate, but not in seconds.

    Raises:
        InputError: they are a thousand, a million or a billion times as long.
    """
    sensors = robot.sensors
    rates = [sensors.rate, *(each.rate for each in sensors.declared.values())]
    declared = [rate for rate in rates if rate]
    if not declared or recording.t.size < 2:
        return
    step = float(np.median(np.diff(recording.t)))
    for unit, count in COUNTS.items():
        if abs(step * max(declared) / count - 1) < DECLARED:
            raise InputError(
                f"{recording.source}: column 't': steps of {step:g} s, and sensors "
                f"have {max(declared):g} Hz; the time seems to be in {unit}: give s"
            )


def base_clocks(robot: Robot, recording: Recording) -> dict[str, Delay]:
    """That of the attitude against the gyro's, where there are both.

    What the robot file declares as latency is no error of a clock.
    """
    gyro, attitude = vector_columns("gyro"), vector_columns("attitude")
    if not recording.has(*gyro, *attitude):
        return {}
    seen = np.logical_and.reduce([~np.isnan(recording.column(name)) for name in gyro])
    rows = _middle(seen & _unbroken(recording.t, seen), MOST)
    w, fixes = (
        np.column_stack([recording.column(name)[rows] for name in names])
        for names in (gyro, attitude)
    )
    declared = delays(robot, recording, {})["attitude"]
    delay = attitude_delay(recording.t[rows], w, fixes, declared)
    return {} if delay is None else {"attitude": delay}


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
    start = max(rows.size - most, 0) // 2
    inner = rows[start : start + most]
    return slice(inner[0], inner[-1] + 1) if inner.size else np.s_[:]
