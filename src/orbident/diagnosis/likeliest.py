"""What may be wrong, by what it would explain to first order, and a trial of it.

Errors of instruments, and those of the robot file that say where a joint is and how its
axis points, are unknowns that the core has; all else is a suspect of its own file.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from typing import NamedTuple

import numpy as np

from orbident.diagnosis.encoders import joint_errors, ripples
from orbident.diagnosis.filters import filters
from orbident.diagnosis.frames import beside
from orbident.diagnosis.jumps import steps
from orbident.diagnosis.late_clocks import SHARED, clocks, fast_clocks
from orbident.diagnosis.shifts import curved_scales, drifts, vibrations
from orbident.diagnosis.suspects import Scores, tried
from orbident.diagnosis.trial import Trial, trial
from orbident.estimation.clock_search import WORTH
from orbident.estimation.estimate import Solved
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.output_error.calibration import calibrations_of
from orbident.estimation.output_error.problem import SENSORS
from orbident.estimation.output_error.sensors import joints_with_torques, torque_column
from orbident.estimation.unknowns import CalibrationFit
from orbident.files.names import joined
from orbident.preprocessing.wrenches import Wrenches, thrust_seen
from orbident.robot.description import Robot

LIKELIEST = 3
"""So many are tried, of all that have a score."""

FIRST_ORDER = 0.5
"""Part of the score of what is accepted above which another one may explain as much:
scores are of first order."""


class Scored(NamedTuple):
    """What may be wrong, before it is tried."""

    falls: float
    """Fall of chi-square that it would bring, to first order, less its price."""
    cause: str
    put: Callable[[], Iterable[Trial]]
    """Puts it right, and tries."""


def likeliest(untried: list[Scored]) -> Iterator[Trial]:
    """Suspects and kinds of instruments' errors with the best scores, tried.

    Beside one that is accepted only those are that may explain as much.
    """
    least = WORTH
    for _ in range(LIKELIEST):
        if untried and untried[0].falls > least:
            first = untried.pop(0)
            for one in first.put():
                if one.accepted:
                    least = max(least, FIRST_ORDER * first.falls)
                yield one._replace(score=first.falls)


def every_score(solved: Solved, before: float, far: bool) -> Iterator[Scored]:
    """What each of them would explain to first order, and how it is tried.

    Args:
        solved: the fit that they are scored at.
        before: its misfit.
        far: whether clocks are far off: their scores are of what is small.
    """
    problem, shown = solved.problem, solved.shown
    if shown is None or shown.solution is None or shown.sensitivity is None:
        return
    price = np.log(problem.samples.t.size)
    table = shown.sensitivity()
    driven = joints_with_torques(problem.robot, problem.recording)
    for kind in kinds(problem.robot, problem.samples.wrenches, driven):
        first = table.together(kind.names)
        declared = [
            each.beyond_tolerance
            for name, each in shown.calibration.items()
            if name in kind.names and np.isfinite(each.tolerance)
        ]
        if numbers := first.values.size + len(declared):
            gain = first.fall + sum(declared) - price * numbers
            yield Scored(gain, f"{kind} is off", partial(freed, problem, kind))
    late = table.together([f"{name}.clock" for name in SHARED])
    if late.values.size and not far:
        now = dict.fromkeys(SHARED, 0.0)
        gain = late.fall - price * late.values.size
        yield Scored(gain, "a clock is late", partial(clocks, problem, now))
    suspects = (
        *beside(problem),
        *steps(problem, shown),
        *drifts(problem),
        *vibrations(problem, shown),
        *joint_errors(problem, shown),
        *ripples(problem, shown),
        *fast_clocks(problem),
        *filters(problem),
        *curved_scales(problem),
    )
    scores = Scores(problem, shown.solution).of(suspects)
    for suspect, first in zip(suspects, scores, strict=True):
        gain = first.fall - price * first.values.size
        if first.values.size and np.abs(first.values).max() <= suspect.most:
            put = partial(tried, problem, suspect, first, before)
            yield Scored(gain, suspect.words(first.values), put)


ANGLE, LENGTH, PART = 0.2, 0.2, 0.1
"""Errors that instruments may have, rad, m and relative: far beyond good ones."""

LATE, THRUST = 0.3, 0.5
"""Deviations beforehand of thrusters, s and relative: a computer far away commands."""

OTHERWISE, ROTOR = 2.0, 10.0
"""Deviations beforehand of a torque's scale, relative, which holds another sign, and of
what rotors behind gears add to a joint's inertia, kg m^2."""

CLEAR = 5.0
"""Deviations by which an error is none of chance."""

FARTHEST = 3.0
"""Deviations beforehand: a larger error is none of this kind."""

WORDS = {
    "joint zeros": ("the zero of joint {}", ANGLE),
    "joint scales": ("the scale of joint {}", PART),
    "wheel inertias": ("the inertia of wheel {}", PART),
    "wheel axes": ("the tilt of the axis of wheel {}", ANGLE),
    "feature_point": ("the offset of the tracked marker from S", LENGTH),
    "attitude.misalignment": ("the misalignment of the attitude sensor", ANGLE),
    "gyro.misalignment": ("the misalignment of the gyro", ANGLE),
    "gyro.scale": ("the scale of the gyro, or the rate of the clock,", PART),
    "position.scale": ("the scale of the position", PART),
    "thrusters.clock": ("the time at which thrusters act after their commands", LATE),
    "thrusters.pulse": ("how long thrusters are on", LATE),
    "thrusters.scale": ("the thrust of all thrusters together", THRUST),
    "torque scales": ("the scale or the sign of the torque of joint {}", OTHERWISE),
    "armature": ("what the motor's rotor behind a gear adds to joint {}", ROTOR),
    "place": (
        "the place of joint {} on its link in the robot file, so the geometry or "
        "length of that link,",
        LENGTH,
    ),
    "direction": ("the tilt of the axis of joint {} in the robot file", ANGLE),
}
"""What is off, by its family, with the joint or wheel in the place of `{}`; and its
standard deviation beforehand. That of a place or direction is of one joint's axes."""

IN_THE_PLANE = {
    "attitude.misalignment": "the misalignment of the attitude sensor, or the angle "
    "between the inertial axes (frames) of attitude and position,"
}
"""Where two errors are the same turn about z, both are named."""


class ErrorKind(NamedTuple):
    """Errors of one family, as unknowns."""

    family: str
    names: tuple[str, ...]
    words: str
    """The cause, with the joint or wheel in the place of `{}`."""
    std: float
    """Beforehand; SI."""

    def __str__(self) -> str:
        named = self.names[0].split(".")
        return self.words.format(named[1] if len(named) > 1 else "")

    @property
    def of_one(self) -> bool:
        """Whether they are of one instrument or joint, and not one of each."""
        return self.family in self.names[0]


def freed(problem: MomentumProblem, kind: ErrorKind) -> Iterator[Trial]:
    """Identify again, with one kind of error as an unknown."""
    found = trial(kind.words, problem, {kind.family: kind.std})
    errors = found.estimate and {
        name: each
        for name, each in found.estimate.calibration.items()
        if name in kind.names
    }
    if errors and max(abs(x.value) for x in errors.values()) < FARTHEST * kind.std:
        price = len(errors) * np.log(problem.samples.t.size)
        words = _in_words(kind, errors)
        yield found.with_price(price)._replace(cause=words, tolerable=True)


def kinds(
    robot: Robot, wrenches: Wrenches, driven: Iterable[str] = ()
) -> Iterator[ErrorKind]:
    """The kinds of errors that a robot's instruments may have; clocks are apart.

    Args:
        robot: with its joints and wheels.
        wrenches: that were recorded.
        driven: joints whose torques were.
    """
    families: dict[str, list[str]] = {}
    recorded = (*SENSORS, *thrust_seen(wrenches), *map(torque_column, driven))
    for each in calibrations_of(robot, recorded):
        families.setdefault(each.family, []).append(each.name)
    for family, names in families.items():
        key = family if family in WORDS else family.rpartition(".")[2]
        if key in WORDS:
            words, std = WORDS[key]
            if robot.motion == "planar":
                words = IN_THE_PLANE.get(key, words)
            yield ErrorKind(family, tuple(names), words, std)


def _in_words(kind: ErrorKind, errors: Mapping[str, CalibrationFit]) -> str:
    """The words of a kind, with its error that stands out most, and whose else does."""
    name = max(errors, key=lambda name: abs(errors[name].value) / errors[name].std)
    named = name.split(".")
    axis = f" along {named[-1]}" if named[-1] in "xyz" else ""
    value, std = errors[name].value, errors[name].std
    if not (kind.of_one or abs(value) > CLEAR * std):
        # Wheels, such as two of which only the ratio shows.
        owners = dict.fromkeys(each.split(".")[1] for each in errors)
        return f"{kind.words.format(' or '.join(owners))} is off"
    which = kind.words.format(named[1] if len(named) > 1 else "")
    if kind.of_one:
        return f"{which} is off by {value:.3g} +- {std:.1g} (SI){axis}"
    clear = (each for each, x in errors.items() if abs(x.value) > CLEAR * x.std)
    owners = dict.fromkeys(each.split(".")[1] for each in clear)
    also = [owner for owner in owners if owner not in named]
    too = f", and so is that of {joined(also)}" if also else ""
    return f"{which} is off by {value:.3g} +- {std:.1g} (SI){axis}{too}"
