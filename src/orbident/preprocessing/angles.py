"""Angles that a sensor shows modulo a turn."""

from collections import deque

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError

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


def within_a_turn(
    t: Float[np.ndarray, " samples"], angle: Float[np.ndarray, " samples"]
) -> bool:
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
    t: Float[np.ndarray, " samples"],
    angle: Float[np.ndarray, " samples"],
    period: float = 2 * np.pi,
    steady: float = np.inf,
) -> Float[np.ndarray, " samples"]:
    """The same angle with whole periods added, so that it goes on as it went before.

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
    t: Float[np.ndarray, " samples"],
    angle: Float[np.ndarray, " samples"],
    limits: tuple[float, float],
    steady: float,
) -> Float[np.ndarray, " samples"]:
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
