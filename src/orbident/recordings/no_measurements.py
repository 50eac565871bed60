"""Samples that are no measurement, as their sensor itself shows: it had none to give.

Loggers fill a gap with a number that no sensor shows, with zeros, or with the sample
before. All of these are exactly the same number again and again, which noise never is.
"""

from collections.abc import Iterable, Mapping
from functools import reduce

import numpy as np
from jaxtyping import Bool, Float

from orbident.files.names import counted
from orbident.recordings.columns import VECTORS, is_known

SURROUNDINGS = ("nadir", "flow", "sun", "field")
"""Vectors of what is around the base."""

NO_SENSORS = {"force", "torque", "thruster", "torquer", *SURROUNDINGS}
"""Columns of what acts: it may change at once, and is not measured on the robot."""

POSES = {"attitude", "position"}
"""What may be lost from sight. Other sensors may show the same for long: rates at rest,
encoders of joints that are held."""

TORQUE = ".torque"
"""The end of the name of a sensor that may freeze too: its noise never rests."""

FARTHER = 100.0
"""Times: no motion goes so much farther in one sample than in all the others."""

FEWEST = 10
"""Samples, or values that are held: fewer tell nothing of a sensor."""

OFTEN = 0.1
"""Part of the values of a sensor that is held which are shown twice or more, at least:
a logger that is faster by a tenth repeats so many."""

LONGEST_HELD = 20
"""Samples: what stays the same for longer, time and again, is a staircase."""

ZERO_LEAP = 2.0
"""Times the longest step: a motion may begin at zero, and with that step."""

FROZEN = 5
"""Samples in a row: a tracker that is lost, and not a frame that came twice."""

LEAP = 4.0
"""Times the usual step: what a coarse sensor cannot do from one value to the next. A
smooth motion that begins or ends at rest does so by a quarter of it at most."""


def sensor_groups(columns: Iterable[str]) -> dict[str, list[str]]:
    """The columns that belong together, by sensor: what spoils one spoils the others.

    Those that are unknown, and those of what acts on the robot, are left out.
    """
    groups: dict[str, list[str]] = {}
    for name in columns:
        head = name.split(".", 1)[0]
        if is_known(name) and name != "t" and head not in NO_SENSORS:
            groups.setdefault(head if head in VECTORS else name, []).append(name)
    return groups


def reasons_in_words(reasons: Mapping[str, int]) -> list[str]:
    """How many samples there are for each reason, which begins with a noun."""
    said = []
    for reason, count in reasons.items():
        noun, space, rest = reason.partition(" ")
        said.append(f"{counted(count, noun)}{space}{rest}")
    return said


def no_measurements(
    sensor: str, table: Float[np.ndarray, "n columns"]
) -> dict[str, Bool[np.ndarray, " n"]]:
    """Which samples of a sensor are no measurement, by reason.

    - An impossible value: all the others lie a hundred times closer together.
    - Repeats of the sample before, where a tenth of the values is held so. The first of
      each is kept. A coarse sensor repeats too, but then goes on by its smallest step.
    - A pose, a torque or an accelerometer that is frozen: five or more in a row, which
      begin or end with a leap.
    - Zeros alone, to which a position leaps.

    The sensor is the name of its group of columns. The table is in any unit, and NaN
    where there is no sample.
    """
    found, table = {}, table.copy()
    for value in {value for x in table.T for value in _impossible(x)}:
        reason = f"sample with the impossible value {value:.7g}"
        found[reason] = (table == value).any(axis=1)
    for mask in found.values():
        table[mask] = np.nan
    freezes = sensor in POSES or sensor.endswith(TORQUE)
    # One that shows zeros has no noise, and rests.
    freezes |= sensor == "accelerometer" and bool((table != 0).any(axis=1).all())
    found |= repeats(table, freezes)
    for mask in found.values():
        table[mask] = np.nan
    return found | (zeros_alone(table.T, table.T) if is_position(sensor) else {})


def _impossible(x: Float[np.ndarray, " n"]) -> list[float]:
    known = x[~np.isnan(x)]
    if known.size < FEWEST:
        return []
    ends = {float(known.min()), float(known.max())}
    others = known[~np.isin(known, list(ends))]
    if others.size <= known.size / 2:
        return []
    middle = np.median(others)
    reach = np.abs(others - middle).max()
    return [v for v in ends if abs(v - middle) > FARTHER * reach > 0]


def is_position(name: str) -> bool:
    """Whether a column goes on from sample to sample, whatever acts."""
    return name.endswith(".position") or name.split(".", 1)[0] in POSES


def zeros_alone(
    columns: Iterable[Float[np.ndarray, " n"]],
    positions: Iterable[Float[np.ndarray, " n"]],
) -> dict[str, Bool[np.ndarray, " n"]]:
    """Which rows are no samples, although they have numbers, by reason: all are zero.

    A position leaps to zero there and back, or on one side of the first and the last
    rows: twice as far as from any row to the next. The rates of a robot that rests at
    zero may leap, but its positions leave by their usual steps. Columns are those of
    all sensors, or of one, in any unit, and NaN where there is no sample; positions
    those of them that go on from sample to sample.
    """
    columns = tuple(columns)
    # Zeros of an attitude are none already.
    zero = reduce(np.logical_and, ((x == 0) | np.isnan(x) for x in columns))
    zero &= reduce(np.logical_or, (x == 0 for x in columns))
    before, lost = np.cumsum(zero), np.zeros(zero.size, dtype=bool)
    for x in positions if zero.any() else ():
        known = np.flatnonzero(~zero & ~np.isnan(x))
        if known.size < FEWEST:
            continue
        steps = np.abs(np.diff(x[known]))[np.diff(before[known]) == 0]
        rows = np.flatnonzero(zero & (x == 0))
        after = np.searchsorted(known, rows)
        ends = known[np.maximum(after - 1, 0)], known[np.minimum(after, known.size - 1)]
        nearest = np.minimum(*(np.abs(x[end]) for end in ends))
        lost[rows] |= nearest > ZERO_LEAP * steps.max(initial=0.0)
    return {"sample of zeros alone": lost} if lost.any() else {}


def repeats(
    table: Float[np.ndarray, "n columns"], pose: bool = False
) -> dict[str, Bool[np.ndarray, " n"]]:
    """Which samples are shown again, by reason, as `no_measurements` has it.

    The table is in any unit, and NaN where there is no sample; a pose may be frozen.
    """
    rows = np.flatnonzero(~np.isnan(table).any(axis=1))
    x = table[rows]
    same = (x[1:] == x[:-1]).all(axis=1)
    starts = np.flatnonzero(np.append(True, ~same))
    if not same.any() or starts.size < FEWEST:
        return {}

    def of_all(mask: Bool[np.ndarray, " k"], reason: str) -> dict[str, np.ndarray]:
        every = np.zeros(len(table), dtype=bool)
        every[rows] = mask
        return {reason: every} if mask.any() else {}

    lengths = np.diff(np.append(starts, len(x)))
    steps = np.abs(x[starts[1:]] - x[starts[1:] - 1])
    again = lengths > 1
    last, least = steps[again[:-1]], np.where(steps > 0, steps, np.inf).min(axis=0)
    coarse = len(last) > 0 and bool((np.median(last, axis=0) < 2 * least).all())
    often = again.sum() > max(OFTEN * starts.size, FEWEST)
    if often and not coarse and np.median(lengths[again]) <= LONGEST_HELD:
        return of_all(np.append(False, same), "repeat of the sample before")
    if not pose:
        return {}
    leaps = np.linalg.norm(steps, axis=1)
    sharpest = np.maximum(np.append(0.0, leaps), np.append(leaps, 0.0))
    least_leap = np.median(leaps) * (LEAP if coarse else 1 / LEAP)
    frozen = (lengths >= FROZEN) & (sharpest > least_leap)
    return of_all(np.repeat(frozen, lengths), "sample of a frozen sensor")
