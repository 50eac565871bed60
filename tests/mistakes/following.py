"""What a refusal says to do, done by a program as far as it can.

A measurement that is asked for shows the true size where the reason names the true
cause, and that there is nothing of the kind where it names another one.
"""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any, NamedTuple

import numpy as np
from mistake import Mistake
from mistakes import names_cause
from recordings import Clean
from scoring import MOST, scored, worst
from spoiled import Spoiled, tolerating
from visibility import visibility_of

import orbident as oi
from orbident.diagnosis.frames import missing_wheel
from orbident.diagnosis.linear_test import tried_conventions
from orbident.diagnosis.trial import Trial
from orbident.estimation.checks import Check
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.robot.tolerances import CALIBRATION_KINDS

FIND_OUT = "find out which of them it is, and then "
OR_ELSE = "; or perhaps "
"""Between a cause and another one that may look like it."""

CLOCK = r"the clock of the (joints|attitude|position) is (\S+) (ms|s) (?:late|early)"


class Attempt(NamedTuple):
    """What was done, and what came of it."""

    way: str
    outcome: str
    miss: float = float("nan")
    """Deviations of the worst base parameter; NaN where nothing is accepted."""


NOTHING_TO_FOLLOW = Attempt("", "nothing to follow")


@dataclass(frozen=True, eq=False)
class Refusal:
    """What is said first of a recording with a mistake."""

    clean: Clean
    mistake: Mistake
    spoiled: Spoiled
    problem: MomentumProblem
    check: Check
    trials: Sequence[Trial]
    """All that the search for the cause judged."""

    @property
    def trial(self) -> Trial:
        """The one that is accepted, of the recording with the cause put right."""
        judged = (one for one in reversed(self.trials) if one.accepted)
        # Without a fit of all sensors that is the only trial, and no other judges it.
        every = chain(judged, missing_wheel(self.problem))
        return next(one for one in every if one.cause in self.check.reason)

    def again(self, way: str, amended: Spoiled) -> Attempt:
        """Identify what the user has then."""
        score = scored(amended, "maximum-likelihood")
        return Attempt(way, score.outcome, score.misses.base)


def corrected(refusal: Refusal) -> Iterator[Attempt]:
    """Put the cause right by as much as the accepted trial found."""
    estimate, sets = refusal.trial.estimate, oi.minimal_sets(refusal.spoiled.robot)
    assert estimate is not None
    base = estimate.parameters.base
    values = np.where(base.determined, base.values, np.nan)
    std = np.sqrt(np.diag(base.covariance))
    miss = min(worst(values, std, sets.beta(x.theta)) for x in refusal.spoiled.true)
    yield Attempt("corrected", "wrong" if miss > MOST else "right", miss)


def corrected_or_tolerated(refusal: Refusal) -> Iterator[Attempt]:
    """Put it right, and then declare its tolerance where a size is printed."""
    yield from corrected(refusal)
    tolerance = tolerance_of(refusal.trial)
    if tolerance is not None:
        amended = tolerating(refusal.spoiled, tolerance)
        yield refusal.again(f"tolerances: {tolerance}", amended)


def tolerance_of(trial: Trial) -> Mapping[str, Any] | None:
    """What a robot file declares that has a tolerance of the size that is printed."""
    clock = re.search(CLOCK, trial.cause)
    if clock:
        name, size, unit = clock.groups()
        return {"clocks": {name: float(size) / (1e3 if unit == "ms" else 1)}}
    assert trial.estimate is not None
    for name, error in trial.estimate.calibration.items():
        size = f"{error.value:.3g}"
        if f"off by {size} +- {error.std:.1g} (SI)" in trial.cause:
            _, of, *_ = *name.split("."), ""
            kinds = CALIBRATION_KINDS.values()
            entry = next(kind.entry for kind in kinds if name in kind.names(of))
            section, _, key = entry.partition(".")
            std = {key: abs(float(size))} if key else abs(float(size))
            return {section: {of: std} if section == "joints" else std}
    return None


def measured(refusal: Refusal) -> Iterator[Attempt]:
    """With the true size of the true cause put right the recording is the clean one."""
    true = names_cause(refusal.mistake, refusal.check.reason)
    yield Attempt("measured", "measured" if true else "nothing there")


def found_out(refusal: Refusal) -> Iterator[Attempt]:
    """If it is the first of two causes, what is said next is done; else measured."""
    check = refusal.check
    first, _, other = check.reason.partition(OR_ELSE)
    if not names_cause(refusal.mistake, first):
        return measured(replace(refusal, check=replace(check, reason=other)))
    then = check.remedy.removeprefix(FIND_OUT)
    return followed(replace(refusal, check=replace(check, reason=first, remedy=then)))


def converted(refusal: Refusal) -> Iterator[Attempt]:
    """The convention that is named is put right in the recording."""
    conventions = (one.convention for one in tried_conventions(refusal.problem))
    named = next((x for x in conventions if x.cause in refusal.check.reason), None)
    if named is None:
        # What is wrong with commands of thrusters ends in the same words.
        yield NOTHING_TO_FOLLOW
        return
    right = named.written(refusal.problem)
    yield refusal.again("converted", replace(refusal.spoiled, recording=right))


def in_parts(refusal: Refusal) -> Iterator[Attempt]:
    """The rows before an event and, where they fit as well, those after it."""
    when = r"between t = (\S+) and (\S+) s"
    ((end, start),) = re.findall(when, refusal.check.reason)

    def before(of: Spoiled) -> Spoiled:
        return replace(of, recording=of.recording.between(end=float(end)))

    first = refusal.again("rows before", before(refusal.spoiled))
    if first.outcome == "wrong":
        # A short part may hide what the whole shows.
        part = visibility_of(refusal.clean, lambda x: before(refusal.mistake.spoil(x)))
        first = first if part.seen else first._replace(outcome="wrong, not visible")
    yield first
    if "those after" in refusal.check.remedy:
        after = refusal.spoiled.recording.between(float(start))
        last = replace(refusal.spoiled, recording=after, initial_momentum="unknown")
        yield refusal.again("rows after", last)


def of_unknown_momentum(refusal: Refusal) -> Iterator[Attempt]:
    """The robot was not at rest, as the user had said: that is no longer said."""
    unknown = replace(refusal.spoiled, initial_momentum="unknown")
    yield refusal.again("momentum unknown", unknown)


WAYS: Mapping[str, Callable[[Refusal], Iterator[Attempt]]] = {
    FIND_OUT: found_out,
    "measure how large it is, and correct it": measured,
    "correct it, or declare its tolerance in the robot file": corrected_or_tolerated,
    "correct it": corrected,
    "correct the recording or the robot file": converted,
    "identify the rows before and those after": in_parts,
    "identify the part that fits": in_parts,
    "use --initial-momentum unknown": of_unknown_momentum,
    "declare what swings": lambda _: iter([Attempt("", "declared")]),
    "": lambda _: iter([NOTHING_TO_FOLLOW]),
}
"""What is done where a remedy has these words; of several the first counts."""


def followed(refusal: Refusal) -> Iterator[Attempt]:
    """Do what the remedy says."""
    return next(WAYS[words] for words in WAYS if words in refusal.check.remedy)(refusal)
