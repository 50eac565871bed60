"""What a column shows that is no motion: spikes, ends of a range, leaps by a turn."""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy.lib.stride_tricks import sliding_window_view
from scipy.ndimage import binary_closing, median_filter

from orbident import _core
from orbident.errors import InputError
from orbident.gaussian import OF_MEDIAN
from orbident.threads import processors

Column = Float[np.ndarray, " samples"]
"""Samples, NaN where there are none; or their times, s."""

FARTHEST = 12
"""How far away neighbours are that predict a sample, in samples, at most. A burst of
five bad ones spoils less than half of them."""

NEIGHBOURHOOD = 101
"""Samples around one that tell how well samples are predicted there."""

SUSPECT = 6.0
"""Times the local scatter: one sample in five hundred million of Gaussian noise."""

USUAL = 90
"""The usual step from sample to sample in a neighbourhood: so many of its steps are
smaller, which is its 90th percentile."""

LEAP = 4.0
"""Times that step: the sharpest turns of a joint that is sampled well stay below it."""

LONGEST = 10
"""Samples in a row that may be a burst; what lasts longer is motion."""

BESIDE = NEIGHBOURHOOD // 2 + 4 * FARTHEST
"""Samples beside one that tell how well it and those around it are predicted."""

ENDS = 6
"""Samples at either end that are left alone: with neighbours on one side only, what a
filter does there and a spike look the same."""

BLOCK = 16_384
"""Samples that are looked at together, and as many beside them as are needed."""

BIT = 1e-14
"""Rounding of the predictions, over the largest sample."""


@dataclass(frozen=True, eq=False)
class Spikes:
    """Which samples are spikes, and how many; they are reported, not removed."""

    mask: Bool[np.ndarray, " samples"]
    count: int


def find_spikes(t: Column, x: Column, name: str = "x") -> Spikes:
    """Samples that their neighbours do not expect, and that leap out of the motion.

    A spike is more than 6 times the local scatter off the median of 12 cubics, each
    through four neighbours at one distance (Hampel's identifier, on residuals), and by
    4 times more than samples around it usually move from one to the next: what does not
    leap is left for the estimator's statistics. Next to an impact, a step of the rate
    itself, samples may be taken for spikes.

    Args:
        t: times, s, strictly increasing.
        x: any unit; NaN where there is no sample.
        name: what `x` is, for messages.

    Raises:
        InputError: there are fewer than 5 valid samples, infinite values, or times that
            do not increase.
    """
    valid = ~np.isnan(x)
    count = int(valid.sum())
    if count < 5:
        raise InputError(f"{name} has {count} samples; spikes show among 5 or more")
    if count < x.size:
        t, x = t[valid], x[valid]
    spiky = np.zeros(count, dtype=bool)
    for start in range(0, count, BLOCK):
        first, end = max(start - NEIGHBOURHOOD, 0), start + BLOCK
        around = slice(first, end + NEIGHBOURHOOD)
        spiky[start:end] = _spiky(t[around], x[around])[start - first : end - first]
    spiky[:ENDS] = spiky[-ENDS:] = False
    mask = np.zeros(valid.size, dtype=bool)
    mask[valid] = spiky
    return Spikes(mask, int(spiky.sum()))


def _spiky(t: np.ndarray, x: np.ndarray) -> Bool[np.ndarray, " n"]:
    steps = np.abs(np.diff(x, prepend=x[0], append=x[-1]))
    padded = np.pad(steps, NEIGHBOURHOOD // 2, mode="symmetric")
    around_each = sliding_window_view(padded, NEIGHBOURHOOD)

    def leap(edges: slice | np.ndarray) -> Float[np.ndarray, " k"]:
        return LEAP * np.partition(around_each[edges], USUAL, axis=1)[:, USUAL]

    # In all neighbourhoods is what takes most of the time: first what may be a leap.
    may = _close(np.flatnonzero(steps > LEAP * _usual_at_least(padded) / 2))
    at = _close(may[steps[may] > leap(may) / 2])
    least = BIT * np.abs(x).max()
    spiky = np.zeros(x.size, dtype=bool)
    for own in _eventful(at, x.size):
        around = slice(max(own.start - BESIDE, 0), own.stop + BESIDE)
        there = slice(own.start - around.start, own.stop - around.start)
        expected = _core.expected_samples(t[around], x[around], FARTHEST, processors())
        residual = np.abs(x[around] - expected)
        scatter = OF_MEDIAN * median_filter(residual, NEIGHBOURHOOD, mode="reflect")
        edges = slice(own.start, own.stop + 1)
        sharpest = leap(edges)
        beyond = np.maximum(SUSPECT * np.maximum(scatter, least)[there], sharpest[:-1])
        spiky[own] = _bursts(residual[there] > beyond, steps[edges] > sharpest / 2)
    return spiky


def _usual_at_least(padded: Float[np.ndarray, " m"]) -> Float[np.ndarray, " edges"]:
    """What the usual step around each edge is at least.

    A neighbourhood contains a whole block of half its size. No more samples of that
    than of the neighbourhood are larger than the usual one.
    """
    block = NEIGHBOURHOOD // 2
    larger = NEIGHBOURHOOD - 1 - USUAL
    blocks = padded[: padded.size // block * block].reshape(-1, block)
    least = np.partition(blocks, block - 1 - larger, axis=1)[:, block - 1 - larger]
    edges = np.arange(padded.size - 2 * block)
    # The neighbourhood of an edge begins with it, in what is padded.
    return least[-(-edges // block)]


def _close(edges: Int[np.ndarray, " n"]) -> Int[np.ndarray, " k"]:
    """Those near enough to another one to enclose a burst with it."""
    if edges.size < 2:
        return edges[:0]
    near = np.diff(edges) <= LONGEST
    return edges[np.append(near, False) | np.insert(near, 0, False)]


def _eventful(at: Int[np.ndarray, " k"], samples: int) -> Iterator[slice]:
    """Samples that may be in a burst, which two leaps close to each other enclose.

    Most of a recording is far from any, and need not be looked at.
    """
    apart = np.flatnonzero(np.diff(at) > 2 * (LONGEST + 1 + BESIDE)) + 1
    for every in np.split(at, apart) if at.size else ():
        first, last = int(every[0]) - LONGEST - 1, int(every[-1]) + LONGEST + 1
        yield slice(max(first, 0), min(last, samples))


def _bursts(
    suspect: Bool[np.ndarray, " n"], leaps: Bool[np.ndarray, " n+1"]
) -> Bool[np.ndarray, " n"]:
    """Suspects in runs that are no longer than a burst, with a leap at either end.

    Args:
        suspect: samples that were not expected.
        leaps: whether the signal leaps from the sample before each one, and after all.
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[0], suspect.view(np.int8), [0]])))
    result = suspect.copy()
    for start, end in edges.reshape(-1, 2):
        if end - start > LONGEST or not (leaps[start] and leaps[end]):
            result[start:end] = False
    return result


FEWEST = 5
"""Samples: two or three that are equal a coarse gyro has by chance."""

OFTENER = 4.0
"""Times any other value: the highest count of a coarse gyro is 2.4 times as frequent as
the next at the crest of a sine."""

BETWEEN = np.ones(5, dtype=bool)
"""Samples between two at the end of the range: noise lets them drop below it."""


def saturated(
    w: Float[np.ndarray, " n"], moving: Bool[np.ndarray, " n"]
) -> dict[str, Bool[np.ndarray, " n"]]:
    """Which samples of one axis of a gyro are at the end of its range, by reason.

    Args:
        w: rad/s; NaN where there is no sample.
        moving: whether the robot moves: at rest it may show one rate for long.
    """
    shown, counts = np.unique(w[moving & ~np.isnan(w)], return_counts=True)
    if shown.size < FEWEST:
        return {}
    ends = [
        k for k in (0, -1) if counts[k] >= max(FEWEST, OFTENER * counts[1:-1].max())
    ]
    levels = [float(shown[k]) for k in ends if shown[k]]
    if not levels:
        return {}
    sign = "+-" if len(levels) > 1 else ""
    at_end = np.isin(w, levels) & moving
    beyond = np.logical_or(binary_closing(at_end, BETWEEN), at_end)
    reason = f"sample saturated at {sign}{levels[-1]:.4g} rad/s"
    return {reason: beyond & ~np.isnan(w)}


GAP = 10.0
"""Times the usual step from sample to sample: what is farther apart may differ by any
angle."""

TURN = 2 * np.pi
"""rad."""

FULL_TURN = TURN + 1e-6
"""rad, and what a printed pi may be too large."""

QUARTER_TURN = np.pi / 2
"""rad: off a steady motion by more, from one sample to the next, is a leap."""

ROUNDING = 1e-6
"""rad."""

WILD = 0.01
"""Part of the samples that may be anything: each spoils three bends."""

REMEMBERED = 5
"""Rates of which the median predicts the next sample: two bad ones do no harm."""


def within_a_turn(t: Column, angle: Column) -> bool:
    """Whether an angle is shown within one turn, rad, and leaps where it goes on.

    Args:
        t: times, s, strictly increasing.
        angle: NaN where there is no sample.
    """
    seen = ~np.isnan(angle)
    t, x = t[seen], angle[seen]
    if x.size < 3 or np.ptp(np.quantile(x, [WILD, 1 - WILD])) > FULL_TURN:
        return False
    dt = np.diff(t)
    close = dt < GAP * np.median(dt)

    def bends(x: Float[np.ndarray, " n"]) -> Float[np.ndarray, " m"]:
        bend = np.abs(np.diff(np.diff(x) / dt) * dt[1:])
        return bend[close[1:] & close[:-1]]

    leaps = bends(x) > QUARTER_TURN
    on = bends(unwrapped(t, x))
    # Samples that are far apart leap by themselves, and whole turns always soften that.
    if not leaps.any() or np.quantile(on, 1 - 3 * WILD) > QUARTER_TURN / 2:
        return False
    usual = 2 * on[~leaps].max(initial=0.0) + ROUNDING
    # Whole turns make no spike go on as its neighbours do.
    return bool(np.median(on[leaps]) < usual)


def unwrapped(
    t: Column, angle: Column, period: float = 2 * np.pi, steady: float = np.inf
) -> Column:
    """An angle that was wrapped, with whole periods added so that it does not leap.

    `x_k = angle_k + period n`, the closest to `x_{k-1} + rate (t_k - t_{k-1})`, with
    the median of the last five rates. So gaps may last several turns while the rate is
    steady, and a wheel that spins up from rest may come to turn by more than half a
    period from one sample to the next.

    Args:
        t: times, s, strictly increasing.
        angle: in the unit of `period`; NaN where there is no sample.
        period: of a turn: 2 pi rad, or whatever the sensor has.
        steady: how long it may go on at the same rate, s; after longer gaps it is as
            close to where it was as can be.

    Returns:
        The first sample as it is; NaN where there is no sample.

    Raises:
        InputError: the period is not positive and finite.
    """
    if not 0 < period < np.inf:
        raise InputError(f"period {period:g}; give a positive number")
    valid = np.flatnonzero(np.isfinite(angle))
    result = angle.copy()
    if not valid.size:
        return result
    rates: deque[float] = deque(maxlen=REMEMBERED)
    times, angles = t[valid].tolist(), angle[valid].tolist()
    x = angles[0]
    found = [x]
    for k in range(1, len(angles)):
        dt = times[k] - times[k - 1]
        rate = sorted(rates)[len(rates) // 2] if rates and dt < steady else 0.0
        step = angles[k] + period * round((x + rate * dt - angles[k]) / period) - x
        rates.append(step / dt)
        x += step
        found.append(x)
    result[valid] = found
    return result


def turned_between(
    t: Column, angle: Column, limits: tuple[float, float], steady: float
) -> Column:
    """An angle with whole turns added where it would be beyond its limits, rad.

    Args:
        t: times, s, strictly increasing.
        angle: that goes on, but may be in another turn after gaps; NaN where there is
            no sample.
        limits: lower and upper.
        steady: what is longer is a gap, s.
    """
    seen = np.flatnonzero(~np.isnan(angle))
    if not seen.size:
        return angle
    starts = np.append(0, np.flatnonzero(np.diff(t[seen]) > steady) + 1)
    lowest, highest = (
        end.reduceat(angle[seen], starts) for end in (np.minimum, np.maximum)
    )
    # The first of those that are equally good is chosen.
    shifts = TURN * np.array([[0], [-1], [1], [-2], [2]])
    below = np.maximum(limits[0] - lowest - shifts, 0)
    above = np.maximum(highest + shifts - limits[1], 0)
    best = shifts[np.argmin(below + above, axis=0), 0]
    turned = angle.copy()
    turned[seen] += np.repeat(best, np.diff(np.append(starts, seen.size)))
    return turned
