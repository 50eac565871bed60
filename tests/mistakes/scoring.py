"""What a method made of a recording, beside what is true."""

import time
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np
from mistake import Mistake
from mistakes import names_cause
from recordings import clean
from remembered_fits import fits_remembered
from spoiled import Spoiled, tolerating

import orbident as oi
from orbident.estimation.identify import METHODS, Method
from orbident.estimation.result import Result

MOST = 5.0
"""Deviations by which a result that is accepted may be off: of a normal error beyond
them there is one in two million."""

Outcome = Literal["refused", "right", "wrong", "crashed"]


class Misses(NamedTuple):
    """The worst errors over their deviations; NaN where nothing is determined."""

    base: float
    """The worst of `M, sigma, iota`."""
    mass: float
    pi: float
    phi: float


UNKNOWN = Misses(*[float("nan")] * 4)


@dataclass(frozen=True)
class Score:
    """What one method made of one recording."""

    outcome: Outcome
    misses: Misses
    """The misses of what is accepted; NaN where nothing is."""
    reasons: tuple[str, ...]
    """Why it is refused, or what is warned of; the first one first."""
    seconds: float

    @property
    def reason(self) -> str:
        """The first one; empty where there is none."""
        return next(iter(self.reasons), "")


def scored(spoiled: Spoiled, method: Method, causes: bool = False) -> Score:
    """Identify, and compare.

    Args:
        spoiled: a recording and what is true.
        method: of identification.
        causes: whether to look for the cause of a refusal.
    """
    started = time.perf_counter()

    def score(outcome: Outcome, misses: Misses, *reasons: str) -> Score:
        return Score(outcome, misses, reasons, time.perf_counter() - started)

    try:
        result = oi.identify(
            spoiled.robot,
            spoiled.recording,
            method=method,
            initial_momentum=spoiled.initial_momentum,
        )
        if causes and result.status == "rejected":
            result = result.with_causes()
    except oi.InputError as error:
        return score("refused", UNKNOWN, str(error))
    except Exception as error:
        return score("crashed", UNKNOWN, f"{type(error).__name__}: {error}")
    if result.status == "rejected":
        return score("refused", UNKNOWN, *result.warnings)
    misses = min(
        (misses_of(result, robot) for robot in spoiled.true), key=lambda m: m.base
    )
    return score(
        "right" if not misses.base > MOST else "wrong", misses, *result.warnings
    )


def worst(values: np.ndarray, std: np.ndarray, expected: np.ndarray) -> float:
    """The worst error over its deviation; NaN where nothing is determined."""
    determined = np.isfinite(values)
    if not determined.any():
        return float("nan")
    with np.errstate(divide="ignore", invalid="ignore"):
        miss = np.abs(values - expected)[determined] / std[determined]
    # A deviation that is not a number promises nothing that could be kept.
    return float(np.nan_to_num(miss, nan=np.inf).max())


def misses_of(result: Result, true: oi.Robot) -> Misses:
    """The misses from the result's own formulas, evaluated for the true bodies."""
    sets = oi.minimal_sets(result.robot)
    base, mass = result.base, result.mass
    beta = sets.beta(true.theta)
    M = worst(np.array([mass.value]), np.array([mass.std]), beta[:1])
    return Misses(
        base=float(np.fmax(worst(base.values, base.std, beta), M)),
        mass=M,
        pi=worst(result.pi.values, result.pi.std, sets.pi(true.theta)),
        phi=worst(result.phi.values, result.phi.std, sets.phi(true.theta)),
    )


class Row(NamedTuple):
    """One mistake on one robot, by all methods."""

    robot: str
    mistake: Mistake
    scores: dict[Method, Score]

    @property
    def unobservable(self) -> bool:
        """Whether other parameters give the same data."""
        return self.robot in self.mistake.unobservable

    def named(self, method: Method) -> bool:
        """Whether the first reason is the true one."""
        return names_cause(self.mistake, self.scores[method].reason)

    def excused(self, method: Method) -> bool:
        """Whether what is accepted and wrong could not have been known."""
        return self.unobservable and self.scores[method].outcome == "wrong"


def row(
    robot: str,
    mistake: Mistake,
    methods: tuple[Method, ...] = METHODS,
    causes: bool = False,
    usual: bool = False,
) -> Row:
    """Make the mistake once, and let every method judge it.

    The cause is looked for by what the sensors show, so it is that of the first method
    for all of them. With the `usual` tolerances these are in the robot's file.
    """
    spoiled = mistake.spoil(clean(robot))
    if usual:
        spoiled = tolerating(spoiled, {})
    with fits_remembered():
        first, *others = methods
        scores: dict[Method, Score] = {first: scored(spoiled, first, causes)}
        for method in others:
            score = scored(spoiled, method)
            if causes and score.outcome == scores[first].outcome == "refused":
                score = replace(score, reasons=(scores[first].reason, *score.reasons))
            scores[method] = score
    return Row(robot, mistake, scores)
