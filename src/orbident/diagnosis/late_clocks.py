"""Which clock, were it late or early, fast or slow, would explain what sensors show."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from orbident.diagnosis.linear_test import ROWS, linear_misfit
from orbident.diagnosis.suspects import Numbers, Suspect
from orbident.diagnosis.trial import Trial, trial
from orbident.errors import InputError
from orbident.estimation.clock_search import far_clock
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.preprocessing.delays import corrections
from orbident.recordings.recording import Recording

UNKNOWN = 0.1
"""Std of a clock beforehand, s."""

NEAREST = 0.1
"""s: a clock is tried so early and so late first. Where both fit far worse than it does
as recorded, it is tried no farther off. The clock of joints is found by Eq. 24."""
FARTHER = (-1.0, -0.5, -0.2, 0.2, 0.5, 1.0)  # s

HELPS = 0.7
"""Part of the linear residuals that a clock that is far off must leave at most."""

ROUNDS = 4
SETTLED = 5e-4
"""s: what is left of a clock's error does not show in what is nonlinear in it."""

CLEAR = 5.0
"""Deviations."""

ALIKE = 0.1
"""Clocks that are off by the same, but for this part, are right: another is off."""

SHARED = {
    "joints": ("joints", "wheels"),
    "attitude": ("attitude",),
    "position": ("position",),
}

APART = "joints", "attitude"
"""Those that are corrected beside the gyro's before any fit."""

Late = Mapping[str, float]


class Corrected(NamedTuple):
    """Clocks that were corrected before anything was tried."""

    recorded: MomentumProblem
    """On the clocks as they are."""
    before: Trial
    """What comes of that."""
    cause: str
    """Which were corrected: a clause."""


def already_corrected(problem: MomentumProblem) -> Corrected | None:
    """The clocks that a refused problem is on already; None where as recorded."""
    late = {name: d.late for name, d in problem.clocks.items() if d.believed}
    if not any(late.values()):
        return None
    clocks = {name: d._replace(believed=False) for name, d in problem.clocks.items()}
    recorded = replace(problem, clocks=clocks).amended()
    words = _in_words({name: (late.get(name, 0.0), 0.0) for name in APART})
    return Corrected(recorded, trial("", recorded), words)


def clocks(problem: MomentumProblem, roughly: Late) -> Iterator[Trial]:
    """Identify again, with the clocks of all sensors but the gyro as unknowns.

    Args:
        problem: of a recording.
        roughly: where to look, s late.
    """
    free = {f"{name}.clock": UNKNOWN for name in SHARED}
    late, found = {**roughly}, None
    corrected = corrections(problem.clocks)
    for _ in range(ROUNDS):
        try:
            found = trial("", _behind(problem, late), free)
        except InputError:  # Too little is left where all clocks show something.
            return
        if found.estimate is None:
            return
        # A row apart by less than is known of a clock is none of its own.
        errors = {
            name.removesuffix(".clock"): error._replace(
                value=error.value * (abs(error.value) > CLEAR * error.std)
            )
            for name, error in found.estimate.calibration.items()
            if name in free
        }
        late |= {name: late[name] + error.value for name, error in errors.items()}
        # Without a gyro the others' clocks are beside that of the attitude.
        beside = 0.0 if "attitude" in errors else late["attitude"]
        off = {name: late[name] - beside + corrected.get(name, 0.0) for name in errors}
        words = {_of(problem, name): (off[name], errors[name].std) for name in errors}
        found = found._replace(cause=_in_words(words), tolerable=True)
        changes = [abs(error.value) for error in errors.values()]
        if found.accepted or not SETTLED < max(changes, default=0.0) < UNKNOWN:
            break
    if found is not None and found.cause:
        yield found


def far_off(problem: MomentumProblem) -> dict[str, float]:
    """Clocks that are so far off that their effect is no longer in proportion."""
    part, now = problem.beginning(ROWS), dict.fromkeys(SHARED, 0.0)
    here = linear_misfit(part)

    def left(names: Sequence[str], late: float) -> tuple[float, dict[str, float]]:
        tried = now | dict.fromkeys(names, late)
        try:
            return linear_misfit(_behind(part, tried)), tried
        except InputError:
            return np.inf, tried

    found = [(HELPS * here, now), left(["joints"], far_clock(problem).late)]
    for names in (["attitude"], ["position"], [*SHARED]):
        near = [left(names, late) for late in (-NEAREST, NEAREST)]
        # A clock that fits far better than a little off it is right.
        if here > HELPS * min(misfit for misfit, _ in near):
            found += [*near, *(left(names, late) for late in FARTHER)]
    _, late = min(found, key=lambda each: each[0])
    return late


def _behind(problem: MomentumProblem, late: Late) -> MomentumProblem:
    """The problem with later clocks than the robot file says."""
    sensors, later = problem.robot.sensors, {}
    for name, seconds in late.items():
        for each in SHARED[name]:
            sensor = sensors.of(each)
            latency = {"latency": (sensor.latency or 0.0) + seconds}
            later[each] = sensor.model_copy(update=latency)
    sensors = sensors.model_copy(update=later)
    return problem.amended(robot=replace(problem.robot, sensors=sensors))


def _of(problem: MomentumProblem, name: str) -> str:
    """The sensor whose clock it is: a tracker may show the velocity alone."""
    if name == "position" and not problem.recording.has("position.x"):
        return "velocity"
    return name


def _in_words(late: Mapping[str, tuple[float, float]]) -> str:
    sure = {name: s for name, (s, std) in late.items() if abs(s) > CLEAR * std}
    if len(sure) == len(late) > 1:
        mean = float(np.mean([*sure.values()]))
        if max(abs(s - mean) for s in sure.values()) < ALIKE * abs(mean):
            # All others are behind the gyro, or the attitude where there is no gyro.
            return _one("gyro" if "attitude" in late else "attitude", -mean)
    return " and ".join(_one(name, seconds) for name, seconds in sure.items())


def _one(name: str, seconds: float) -> str:
    way, size = "late" if seconds > 0 else "early", abs(seconds)
    by = f"{size:.3g} s" if size >= 1 else f"{1e3 * size:.3g} ms"
    return f"the clock of the {name} is {by} {way}"


SMALL = 1e-5
"""A clock that is so much too fast is a millisecond off after 100 s."""

CLOCKS = {
    "joints": ("joint.", "wheel."),
    "position": ("position.", "velocity."),
}
"""Sensors that may have a clock of their own, and what their columns begin with."""


def fast_clocks(problem: MomentumProblem) -> Iterator[Suspect]:
    """Sensors whose clock runs fast beside the others', from the first sample on."""
    for name, columns in CLOCKS.items():
        if not any(each.startswith(columns) for each in problem.recording.columns):
            continue

        def words(c: Numbers, name: str = _of(problem, name)) -> str:
            way = "fast" if c[0] > 0 else "slow"
            return f"the clock of the {name} runs {100 * abs(c[0]):.2g} % {way}"

        def corrected(
            problem: MomentumProblem, c: Numbers, columns: tuple[str, ...] = columns
        ) -> MomentumProblem:
            recording = problem.recording
            return problem.amended(recording=_slower(recording, columns, c[0]))

        yield Suspect(words, np.array([SMALL]), corrected)


def _slower(recording: Recording, columns: tuple[str, ...], part: float) -> Recording:
    """What is recorded at `t` is what was so at `(1 + part) t`; `t_0` is zero.

    A row beyond the ends of the recording is still near enough.
    """
    t = recording.t
    at, row = t[0] + (t - t[0]) / (1 + part), float(np.median(np.diff(t)))
    right = {}
    for name, column in recording.columns.items():
        seen = np.isfinite(column)
        if name.startswith(columns) and np.count_nonzero(seen) > 1:
            first, last = t[seen][[0, -1]]
            near = (at > first - row) & (at < last + row)
            right[name] = np.where(near, CubicSpline(t[seen], column[seen])(at), np.nan)
    return recording.with_columns(right)
