"""Which instrument's error, were it unknown, would explain what the sensors show.

Where a joint is, and how its axis points, are errors of the robot file: the core has
them beside those of instruments.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from orbident.diagnosis.trial import Trial, amended_trial
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.unknowns import CalibrationFit
from orbident.robot.description import Robot

ANGLE, LENGTH, PART = 0.2, 0.2, 0.1
"""Errors that instruments may have, rad, m and relative: far beyond good ones."""

CLEAR = 5.0
"""Deviations by which an error is none of chance."""

EACH = "(.+)"
"""The part of a pattern that matches the name of any joint or wheel."""


class ErrorKind(NamedTuple):
    """Errors of one kind, as unknowns."""

    words: str
    """The cause, with the joint or wheel in the place of `{}`."""
    names: str
    """A pattern that the names of its errors match; its group is a joint or wheel."""
    tolerance: Mapping[str, Any]
    """As `Tolerances` has it."""

    def errors(self, names: Sequence[str]) -> list[int]:
        """Which of these are errors of this kind."""
        return [k for k, name in enumerate(names) if self.has(name)]

    def has(self, name: str) -> bool:
        """Whether it is an error of this kind."""
        return re.fullmatch(self.names, name) is not None


def freed(problem: MomentumProblem, kind: ErrorKind) -> Iterator[Trial]:
    """Identify again, with one kind of error as an unknown."""
    robot = problem.robot
    loose = replace(robot, tolerances=replace(robot.tolerances, **kind.tolerance))
    found = amended_trial(kind.words, problem, loose)
    errors = found.estimate and {
        name: each
        for name, each in found.estimate.calibration.items()
        if kind.has(name)
    }
    # Of one instrument, what tells its axes apart need not be clear.
    one = EACH not in kind.names
    if errors and (one or any(abs(x.value) > CLEAR * x.std for x in errors.values())):
        # As many unknowns explain so much by chance (Schwarz 1978).
        price = len(errors) * np.log(problem.samples.t.size)
        words = _in_words(kind, errors)
        yield found._replace(cause=words, misfit=found.misfit + price, tolerable=True)


def kinds(robot: Robot) -> Iterator[ErrorKind]:
    """The kinds of errors that a robot's instruments may have, with wide tolerances."""
    zeros = {joint.name: ANGLE for joint in robot.joints}
    scales = dict.fromkeys(robot.joint_names, PART)
    place = (
        "the place of joint {} on its link in the robot file, so the geometry or "
        "length of that link,"
    )
    yield ErrorKind(
        "the zero of joint {}", rf"joint\.{EACH}\.zero", {"joint_zero": zeros}
    )
    yield ErrorKind(
        "the scale of joint {}", rf"joint\.{EACH}\.scale", {"joint_scale": scales}
    )
    for name in robot.joint_names:
        own = re.escape(name)
        for words, error, size in (
            (place, "place", LENGTH),
            ("the tilt of the axis of joint {} in the robot file", "direction", ANGLE),
        ):
            tolerance = {f"joint_{error}": {name: size}}
            yield ErrorKind(words, rf"joint\.({own})\.{error}\.[xyz]", tolerance)
    wheels = {"wheel_inertia": PART}
    yield ErrorKind("the inertia of wheel {}", rf"wheel\.{EACH}\.inertia", wheels)
    for words, name, tolerance in (
        ("the offset of the tracked marker from S", "feature_point", LENGTH),
        ("the misalignment of the attitude sensor", "attitude.misalignment", ANGLE),
        ("the misalignment of the gyro", "gyro.misalignment", ANGLE),
        ("the scale of the gyro, or the rate of the clock,", "gyro.scale", PART),
        ("the scale of the position", "position.scale", PART),
    ):
        own = rf"{re.escape(name)}(\.[xyz])?"
        yield ErrorKind(words, own, {name.replace(".", "_"): tolerance})


def _in_words(kind: ErrorKind, errors: Mapping[str, CalibrationFit]) -> str:
    """The words of a kind, with its error that stands out most."""
    name = max(errors, key=lambda name: abs(errors[name].value) / errors[name].std)
    named = name.split(".")
    axis = f" along {named[-1]}" if named[-1] in "xyz" else ""
    value, std = errors[name].value, errors[name].std
    which = kind.words.format(named[1] if len(named) > 1 else "")
    return f"{which} is off by {value:.3g} +- {std:.1g} (SI){axis}"
