"""Whether a recording is good until something happens, or without one instrument.

Both are facts, since both were tried; what may be behind them stands after "perhaps".
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from orbident.diagnosis.shifts import without
from orbident.diagnosis.trial import Trial, amended_trial
from orbident.estimation.changes import ANOTHER_ROBOT, changes_of, differing
from orbident.estimation.checks import Check
from orbident.estimation.linear_fits import InitialMomentum
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.output_error.sensors import COMPONENTS
from orbident.files.names import joined

HALVINGS = 4
"""How often the stretch of time in which the event may lie is halved."""

FEWEST = 20
"""Samples of a part that may be identified for itself."""

BY_PART = "identify the part that fits, or remove what acts"


class Event(NamedTuple):
    """What happened in the course of a recording, in words."""

    fact: str
    perhaps: str
    """Usual reasons of it."""
    remedy: str = BY_PART
    sure: bool = True
    """Whether it explains all: else it may be that a short part shows less."""
    sensors: tuple[str, ...] = ()
    """Those that do not agree with the others."""

    def words(self, likeliest: str = "") -> str:
        """A clause.

        Args:
            likeliest: of all causes that were tried, that which explains most; what is
                said of another sensor than does not agree cannot be.
        """
        if any(f"the {sensor}" in likeliest for sensor in self.sensors):
            return f"{self.fact} (perhaps {likeliest})"
        more = "" if self.sensors or not likeliest else likeliest
        more = more and f"; of all that was tried most is explained if {more}"
        return f"{self.fact} (perhaps {self.perhaps}){more}"


def event(problem: MomentumProblem) -> Event | None:
    """What happened; None where neither a part fits, nor the whole without a sensor.

    Only what is said to fit was tried: what stands in brackets after "perhaps" are
    usual reasons, which nothing here tests.
    """
    t = problem.recording.t
    good, bad, before = _until(problem)
    apart = _disagreeing(problem)
    if before is None:
        return _apart(apart, "") if apart else None
    at = f"between t = {t[good - 1]:.3g} and {t[bad - 1]:.3g} s"
    after = _part(problem, slice(bad, None), "unknown")
    same = after.fits and _same(before, after)
    unclear = not after.fits and problem.initial_momentum == "at-rest"
    if apart:
        # A push through the CM shows in positions alone, which then drift evenly.
        pushed = ", or the robot was pushed, by a thruster's burst"
        pushed = pushed if same else f"{pushed}, or changed" if unclear else ""
        return _apart(apart, f"; it begins {at}", pushed)
    if unclear:
        return Event(
            f"the recording fits up to some time {at}",
            "there was a push then, such as a thruster's burst, or the robot changed "
            "by a capture",
            sure=False,
        )
    if not after.fits:
        return Event(
            f"the recording stops to fit {at}, and what follows does not fit either",
            "an external torque acts, by drag or friction, or a wheel's speed is not "
            "as recorded",
            sure=False,
        )
    if not same:
        return _other_robot(at)
    return Event(
        f"an event {at}: before and after the recording fits, with the same parameters",
        "a push, such as a thruster's burst",
        "give the rows before and those after as two recordings of one robot: each has "
        "a momentum of its own",
    )


def plain_change(problem: MomentumProblem) -> list[Check]:
    """A change of the robot, which is seen before the whole is fitted."""
    changes = changes_of(problem)
    if not changes:
        return []
    times = [f"between t = {each.onset:.4g} and {each.t:.4g} s" for each in changes]
    event = _other_robot(joined(times))
    return [Check("cause", "do not trust", event.words(), event.remedy)]


def _other_robot(at: str) -> Event:
    return Event(
        f"before and after an event {at} the recording fits, with different parameters",
        "the robot changed, by a capture or a release, or an instrument did",
        "identify the rows before and those after each by themselves, and compare the "
        "two results: that says what was captured",
    )


def _disagreeing(problem: MomentumProblem) -> list[str]:
    """The sensors without which the others fit.

    The first `FEWEST` samples of the sensor stay in the recording, because without any
    velocity of S the mass could not be estimated.
    """
    recording = problem.recording
    later = np.arange(recording.t.size) >= FEWEST
    return [
        sensor
        for sensor in COMPONENTS
        if recording.has_vector(sensor)
        and amended_trial("", problem, recording=without(recording, sensor, later)).fits
    ]


def _apart(sensors: list[str], when: str, pushed: str = "") -> Event:
    """What is known of sensors that do not agree with the others."""
    without, which = "it", "it"
    if len(sensors) > 1:
        without, which = f"{'either' if len(sensors) == 2 else 'any'} of them", "one"
    return Event(
        f"the {joined(sensors)} and the other instruments do not agree{when}: without "
        f"{without} the recording fits",
        f"{which} drifts, jumps (a step), has errors that last or a clock that is off, "
        f"or an encoder is off{pushed}",
        "leave it out, or compare the instruments where the robot rests or is moved by "
        "hand",
        sensors=tuple(sensors),
    )


def _until(problem: MomentumProblem) -> tuple[int, int, Trial | None]:
    """Rows of the longest beginning that fits, and of the shortest that does not.

    What acts must act from the first beginning on: an event that is not long ago may
    pass for a disturbance.
    """
    rows = problem.recording.t.size
    good, bad, found, acting = 0, rows, None, set[str]()
    for _ in range(HALVINGS):
        middle = (good + bad) // 2
        tried = _part(problem, slice(middle), problem.initial_momentum)
        acts = tried.estimate.acting if tried.estimate else set[str]()
        if tried.fits and (found is None or acts <= acting):
            good, found, acting = middle, tried, acts
        else:
            bad = middle
    return good, bad, found


def _part(
    problem: MomentumProblem, rows: slice, initial_momentum: InitialMomentum
) -> Trial:
    recording = problem.recording
    if recording.t[rows].size < FEWEST:
        return Trial("", False, np.inf)
    known = replace(problem, initial_momentum=initial_momentum)
    return amended_trial("", known, recording=recording.some(rows))


def _same(one: Trial, other: Trial) -> bool:
    """Whether two parts show the same robot."""
    assert one.estimate is not None
    assert other.estimate is not None
    return not differing(one.estimate, other.estimate).is_no_chance(ANOTHER_ROBOT)
