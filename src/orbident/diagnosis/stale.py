"""Samples that are the same as the one before: a logger that holds, a dead encoder."""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Bool, Float

from orbident.diagnosis.shifts import shown_by
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot

OFTEN = 0.3
"""Part of the samples that repeat: noise never does, coarse encoders less often."""

LONG = 10
"""Samples in a row that are the same though the others are not."""

COUNTS = 3.0
"""Times the least step of a sensor: a coarse one shows the same until it moved so far,
and a sensor that was stuck leaps."""

WHOLE = 0.01
"""Changes that are within this part of a whole number of steps are whole steps: the
rounding of decimals leaves less."""


def stale(robot: Robot, recording: Recording) -> Iterator[str]:
    """What repeats, in words; first what does so throughout."""
    same = {}
    for sensor, x in shown_by(robot, recording).items():
        most = x[:, np.argmax(np.nanstd(x, axis=0))]
        seen = np.isfinite(most)
        if np.ptp(most[seen]) > 0:
            same[sensor.replace(".", " ")] = recording.t[seen][1:], most[seen]
    often = {name: np.mean(np.diff(x) == 0) for name, (_, x) in same.items()}
    held = [name for name, part in often.items() if part > OFTEN]
    if len(held) == len(often) > 0:
        yield "rows repeat: all sensors show the same again and again"
    elif held:
        words = ", ".join(
            f"{name} in {often[name]:.0%} of the rows{_rounded(same[name][1])}"
            for name in held
        )
        yield f"samples repeat the one before: {words}"
    for name, (t, x) in same.items():
        run = _longest(np.diff(x) == 0)
        if name not in held and run is not None and _leaps_beside(x, *run):
            start, end = run
            words = f"{name} is stuck: the same value from t = {t[start]:.4g} to "
            yield f"{words}{t[end]:.4g} s"


def _rounded(x: Float[np.ndarray, " n"]) -> str:
    """Whether all that changes changes by whole steps, in words."""
    moves = np.abs(np.diff(x))
    counts = moves[moves > 0] / moves[moves > 0].min()
    whole = np.abs(counts - np.round(counts)).max() < WHOLE
    return f" (rounded to {moves[moves > 0].min():.2g})" if whole else ""


def _longest(again: Bool[np.ndarray, " n"]) -> tuple[int, int] | None:
    """The longest run, where it is long; a sensor that rests for long is not stuck."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], again.astype(int), [0]])))
    starts, ends = edges[::2], edges[1::2]
    if not starts.size:
        return None
    k = int(np.argmax(ends - starts))
    if ends[k] - starts[k] < LONG:
        return None
    return int(starts[k]), int(ends[k] - 1)


def _leaps_beside(x: Float[np.ndarray, " n"], start: int, end: int) -> bool:
    """Whether it moves by many counts just before or after it shows the same."""
    steps = np.abs(np.diff(x))
    beside = np.append(steps[max(start - LONG, 0) : start], steps[end + 1 :][:LONG])
    return bool(beside.max(initial=0.0) > COUNTS * steps[steps > 0].min())
