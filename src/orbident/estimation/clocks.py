"""Whether the clock of the attitude agrees with that of the gyro, and what is said.

That of joints and wheels is looked for by output error (`clock_search.py`).
"""

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Bool, Float

from orbident.preprocessing.base_motion import AXES as GYRO
from orbident.preprocessing.base_motion import QUATERNION as ATTITUDE
from orbident.preprocessing.delays import Delay, attitude_delay, delays
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot

MOST = 2**13
"""Samples; the middle of a longer recording is enough."""

GAP = 10.0
"""Times the usual step from sample to sample."""


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
