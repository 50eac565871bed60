"""Rates of measured positions by cubic splines, and columns that are no such rates.

Drivers fill columns of joint velocities with zeros or with a limit, with the motor's
rate, or with one that was filtered. Integrated, a rate `v` must give the position, but
for a bias: over any span of time, `dq = c dt + integral of v`. Integration adds little
noise, and a derivative much. What `v` is instead shows in
`dq = c dt + integral of v / G + T dv`: it is `G` times the rate, and later by `G T`;
exactly so where it is low-passed to first order.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from math import sqrt

import numpy as np
from jaxtyping import Float
from scipy.interpolate import CubicSpline

from orbident.errors import InputError
from orbident.gaussian import white_std
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot


def spline_rates(
    t: Float[np.ndarray, " samples"],
    x: Float[np.ndarray, " samples *columns"],
    name: str = "x",
) -> Float[np.ndarray, " samples *columns"]:
    """Time derivative of each column at every `t`.

    The not-a-knot cubic spline through the valid samples, differentiated. NaN before
    the first and after the last valid sample: an extrapolated rate is mostly noise.

    Args:
        t: Times, s, strictly increasing.
        x: One column or several; NaN where there is no sample.
        name: What `x` is, for messages.

    Raises:
        InputError: A column has fewer than 4 valid samples or infinite values.
    """
    return _by_column(x, name, lambda column, label: _spline(t, column, label)(t, nu=1))


def fill(
    t: Float[np.ndarray, " samples"],
    x: Float[np.ndarray, " samples *columns"],
    name: str = "x",
) -> Float[np.ndarray, " samples *columns"]:
    """Each column with its gaps filled from the same spline; measured values stay.

    Nothing is extrapolated: NaN before the first and after the last valid sample stay.

    Args:
        t: Times, s, strictly increasing.
        x: One column or several; NaN where there is no sample.
        name: What `x` is, for messages.

    Raises:
        InputError: A column has fewer than 4 valid samples or infinite values.
    """

    def filled(column: np.ndarray, label: str) -> np.ndarray:
        gaps = np.isnan(column)
        result = column.copy()
        result[gaps] = _spline(t, column, label)(t[gaps])
        return result

    return _by_column(x, name, filled)


def at_times(
    t: Float[np.ndarray, " samples"],
    x: Float[np.ndarray, " samples"],
    at: Float[np.ndarray, " m"],
    name: str = "x",
) -> Float[np.ndarray, " m"]:
    """The same spline at other times; NaN where it would be extrapolated.

    Args:
        t: Times, s, strictly increasing.
        x: One column; NaN where there is no sample.
        at: Times to evaluate at, s.
        name: What `x` is, for messages.

    Raises:
        InputError: The column has fewer than 4 valid samples or infinite values.
    """
    return _spline(t, x, name)(at)


def through_gaps(t: Float[np.ndarray, " rows"]) -> Float[np.ndarray, " more"]:
    """The times, and between them others in gaps, as far apart as usual.

    What is integrated from row to row goes on through gaps. Where these would have more
    rows than were recorded, nobody knows what happened for so long: they stay.

    Args:
        t: Times, s, strictly increasing.
    """
    steps = np.diff(t)
    usual = float(np.median(steps)) if steps.size else np.inf
    gaps = np.flatnonzero(steps > GAP * usual)
    if steps[gaps].sum() > t.size * usual:
        return t
    parts = np.round(steps[gaps] / usual).astype(int)
    more = [
        np.linspace(t[k], t[k + 1], n, endpoint=False)[1:]
        for k, n in zip(gaps, parts, strict=True)
    ]
    return np.sort(np.concatenate([t, *more]))


def gaps_as_rows(recording: Recording) -> Recording:
    """The recording with rows without a sample in its gaps, as `through_gaps`."""
    t = through_gaps(recording.t)
    if t.size == recording.t.size:
        return recording
    rows = np.searchsorted(t, recording.t)
    columns = {name: np.full(t.size, np.nan) for name in recording.columns}
    for name, column in recording.columns.items():
        columns[name][rows] = column
    return replace(recording, t=t, columns=columns)


def _by_column(
    x: np.ndarray, name: str, work: Callable[[np.ndarray, str], np.ndarray]
) -> np.ndarray:
    # A spline needs several times its data: one column at a time bounds that.
    if x.ndim == 1:
        return work(x, name)
    result = np.empty(x.shape)
    for index in np.ndindex(x.shape[1:]):
        label = f"{name}[:, {', '.join(map(str, index))}]"
        result[:, *index] = work(x[:, *index], label)
    return result


def _spline(t: np.ndarray, column: np.ndarray, label: str) -> CubicSpline:
    valid = ~np.isnan(column)
    count = int(valid.sum())
    if count < 4:
        raise InputError(
            f"{label} has {count} samples; a cubic spline needs at least 4"
        )
    knots, values = (t, column) if count == t.size else (t[valid], column[valid])
    try:
        return CubicSpline(knots, values, extrapolate=False)
    except ValueError as error:
        raise InputError(
            f"{label}: no spline ({error}); give finite samples at strictly "
            "increasing times"
        ) from error


OFF = 0.01
"""Part of the motion, or of the scale: a tachometer's is known to some tenths of a
percent."""

SURE = 5.0
"""Times what noise and integration leave."""

EXPLAINED = 0.1
"""Part of the misfit that a gain and a lag may leave, to be named."""

LATE = 0.1
"""Times the usual step: splines are off by less."""

UNLIKE = 1e-4
"""One over the gain of the fastest motor."""

SPANS = 16
"""Part of the recording over which is compared: long enough for a joint to move far,
short enough for gaps and wrong samples to spoil few. One over it."""

FEWEST = 2 * SPANS
"""Samples with position and velocity, and spans without a gap."""

MOST, ROUNDS = 0.9, 3
"""Part of the spans that counts, the others may have wrong samples; and how often they
are chosen."""

GAP = 10.0
"""Times the usual step: over a longer one rates are not integrated."""


def coarse_speeds(robot: Robot, recording: Recording) -> Iterator[str]:
    """Speeds that never show the noise that the robot file declares, in words.

    Rounding to steps of `s` is off by `s / sqrt(12)`, and by as much for as long as the
    speed stays the same: no number of samples averages it.

    Args:
        robot: with the noise of its tachometers; without it nothing is said.
        recording: without what is no measurement.
    """
    std = (robot.sensors.wheels and robot.sensors.wheels.tachometer) or 0.0
    for wheel in robot.wheel_names if std else ():
        name = f"wheel.{wheel}.speed"
        speed = recording.column(name) if recording.has(name) else np.empty(0)
        speed = speed[~np.isnan(speed)]
        values = np.unique(speed)
        step = np.diff(values).min(initial=np.inf)
        # Of noise no two samples are alike, and of a ramp none.
        if speed.size < FEWEST or values.size > speed.size / 2 or step < sqrt(12) * std:
            continue
        what = f"goes in steps of {step:.3g} rad/s"
        if values.size == 1:
            what = f"is {values[0] + 0.0:g} rad/s throughout"
        yield (
            f"column '{name}' {what}, without the declared noise of {std:g} rad/s: if "
            "it is rounded or a command, no std holds its error; record the true speed"
        )


def false_rates(
    recording: Recording, joints: tuple[str, ...]
) -> Iterator[tuple[str, str]]:
    """Columns of velocities that do not belong to the positions, and what they are.

    Args:
        recording: without what is no measurement, angles unwrapped.
        joints: their names.
    """
    for joint in joints:
        position, velocity = (
            f"joint.{joint}.{what}" for what in ("position", "velocity")
        )
        if not recording.has(position, velocity):
            continue
        q, v = recording.column(position), recording.column(velocity)
        both = ~(np.isnan(q) | np.isnan(v))
        if both.sum() >= FEWEST:
            words = _instead(recording.t[both], q[both], v[both])
            if words:
                yield velocity, words


def _instead(
    t: Float[np.ndarray, " n"], q: Float[np.ndarray, " n"], v: Float[np.ndarray, " n"]
) -> str | None:
    """What `v` is instead of the rate of `q`; None where it is the rate."""
    # Every other one of an odd number of samples is the last.
    t, q, v = (x[: x.size - 1 + x.size % 2] for x in (t, q, v))
    parts = np.cumsum(np.diff(t, prepend=t[0]) > GAP * np.median(np.diff(t)))
    span = t.size // SPANS
    whole = parts[span:] == parts[:-span]
    if whole.sum() < FEWEST:
        return None

    def over(x: np.ndarray) -> np.ndarray:
        return (x[span:] - x[:-span])[whole]

    def left(y: np.ndarray, *columns: np.ndarray) -> tuple[float, np.ndarray]:
        A, b = np.column_stack([over(x) for x in (t, *columns)]), over(y)
        x, off = np.zeros(A.shape[1]), np.zeros(b.size)
        kept = np.ones(b.size, dtype=bool)
        for _ in range(ROUNDS):
            x = np.linalg.lstsq(A[kept], b[kept])[0]
            off = np.abs(b - A @ x)
            kept = off <= np.quantile(off, MOST)
        return float(np.sqrt(np.mean(off[kept] ** 2))), x[1:]

    angle = CubicSpline(t, v).antiderivative()(t)
    by_half = CubicSpline(t[::2], v[::2]).antiderivative()(t)
    unsure, _ = left(angle - by_half)
    moved, _ = left(q)
    misfit, _ = left(q - angle)
    if misfit <= SURE * np.hypot(_noise(q), unsure):
        return None
    if not np.ptp(v):
        return f"is {v[0] + 0.0:g} throughout"
    rest, (inverse, lag) = left(q, angle, v)
    said = ""
    if rest < EXPLAINED * misfit and abs(inverse) > UNLIKE:
        said = _in_words(1 / inverse, lag / inverse, float(np.median(np.diff(t))))
    return said or ("does not follow it" if misfit > OFF * moved else None)


def _in_words(gain: float, late: float, step: float) -> str:
    """What is wrong with a rate; empty where nothing is."""
    said = [f"is {gain:.4g} times that"] if abs(gain - 1) > OFF else []
    if abs(late) > LATE * step:
        said.append(f"is {abs(late):.3g} s {'late' if late > 0 else 'early'}")
    return " and ".join(said)


def _noise(q: Float[np.ndarray, " n"]) -> float:
    """Std of an encoder's samples: fourth differences have 70 times its variance."""
    steps = np.abs(np.diff(q))
    count = steps[steps > 0].min(initial=np.inf)
    bends = float(white_std(q))
    return float(np.hypot(bends, count if np.isfinite(count) else 0.0))
