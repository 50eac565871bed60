"""Whether the clock of joints and wheels agrees with that of the base's sensors.

The delay is found by Gauss-Newton: an equation that is linear in a small delay
(`orbident.estimation.delay_equations`), again and again with joints moved by what was
found.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Float

from orbident.estimation.delay_equations import DelayEquations, MovingJoints
from orbident.estimation.linear_fits import (
    InitialMomentum,
    known_momentum,
)
from orbident.model.minimal_sets import MinimalSets
from orbident.model.wheel_arrays import wheels_of
from orbident.preprocessing.attitude_delay import attitude_delay
from orbident.preprocessing.base_motion import AXES as GYRO
from orbident.preprocessing.base_motion import QUATERNION as ATTITUDE
from orbident.preprocessing.base_motion import SMOOTHED
from orbident.preprocessing.delays import SETTLED, WORTH, Delay, delay_of, delays
from orbident.preprocessing.samples import Samples
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot

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
