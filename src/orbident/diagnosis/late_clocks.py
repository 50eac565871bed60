"""Which sensor's clock, were it late or early, would explain what the sensors show."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from orbident.diagnosis.linear_test import ROWS, linear_misfit
from orbident.diagnosis.trial import Trial, trial
from orbident.errors import InputError
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.preprocessing.delays import corrections

UNKNOWN = 0.1
"""Std of a clock beforehand, s."""

TRIED = (-1.0, -0.5, -0.2, -0.1, 0.1, 0.2, 0.5, 1.0)
"""s: where a clock that is far off is looked for."""

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
    late = corrections(problem.clocks)
    if not any(late.values()):
        return None
    clocks = {name: d._replace(believed=False) for name, d in problem.clocks.items()}
    recorded = replace(problem, clocks=clocks).amended()
    words = _in_words({name: (late.get(name, 0.0), 0.0) for name in SHARED})
    return Corrected(recorded, trial("", recorded), words)


def clocks(problem: MomentumProblem) -> Iterator[Trial]:
    """Identify again, with the clocks of all sensors but the gyro as unknowns."""
    tolerances = replace(
        problem.robot.tolerances,
        joint_clock=UNKNOWN,
        attitude_clock=UNKNOWN,
        position_clock=UNKNOWN,
    )
    free = problem.amended(robot=replace(problem.robot, tolerances=tolerances))
    late, found = _roughly(problem), None
    corrected = corrections(problem.clocks)
    for _ in range(ROUNDS):
        try:
            found = trial("", _behind(free, late))
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
            if name.endswith(".clock")
        }
        late |= {name: late[name] + error.value for name, error in errors.items()}
        words = _in_words(
            {
                name: (late[name] + corrected.get(name, 0.0), error.std)
                for name, error in errors.items()
            }
        )
        found = found._replace(cause=words, tolerable=True)
        changes = [abs(error.value) for error in errors.values()]
        if found.accepted or not SETTLED < max(changes, default=0.0) < UNKNOWN:
            break
    if found is not None and found.cause:
        yield found


def _roughly(problem: MomentumProblem) -> dict[str, float]:
    """Clocks that are so far off that their effect is no longer in proportion."""
    part = problem.beginning(ROWS)
    best, at = HELPS * linear_misfit(part, part.samples), dict.fromkeys(SHARED, 0.0)
    for names in (("joints",), ("attitude",), ("position",), tuple(SHARED)):
        for late in TRIED:
            tried = dict.fromkeys(SHARED, 0.0) | dict.fromkeys(names, late)
            try:
                misfit = linear_misfit(part, _behind(part, tried).samples)
            except InputError:
                continue
            if misfit < best:
                best, at = misfit, tried
    return at


def _behind(problem: MomentumProblem, late: Late) -> MomentumProblem:
    """The problem with later clocks than the robot file says."""
    sensors = dict(problem.robot.sensors)
    for name, seconds in late.items():
        for each in SHARED[name]:
            section = dict(sensors.get(each, {}))
            section["latency"] = section.get("latency", 0.0) + seconds
            sensors[each] = section
    return problem.amended(robot=replace(problem.robot, sensors=sensors))


def _in_words(late: Mapping[str, tuple[float, float]]) -> str:
    sure = {name: s for name, (s, std) in late.items() if abs(s) > CLEAR * std}
    if len(sure) == len(late) > 1:
        mean = float(np.mean([*sure.values()]))
        if max(abs(s - mean) for s in sure.values()) < ALIKE * abs(mean):
            # All others are behind the gyro, or the attitude where there is no gyro.
            return _one("gyro" if "attitude" in late else "attitude", -mean)
    return " and ".join(_one(name, seconds) for name, seconds in sure.items())


def _one(name: str, seconds: float) -> str:
    way = "late" if seconds > 0 else "early"
    return f"the clock of the {name} is {1e3 * abs(seconds):.3g} ms {way}"
