"""Recordings with one thing put right: are they accepted, and which is the best?"""

from collections.abc import Mapping
from contextlib import suppress
from typing import NamedTuple

import numpy as np

from orbident.errors import InputError
from orbident.estimation.allowance import GivenUpError, spend
from orbident.estimation.checks import only_vague, worst
from orbident.estimation.clock_search import WORTH, misfit
from orbident.estimation.criteria import judge
from orbident.estimation.estimate import Estimate, Solved
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.obstacles import obstacles
from orbident.estimation.output_error.calibration import NOTHING_FREE
from orbident.estimation.output_error.estimator import OutputError
from orbident.estimation.output_error.least_cost import FEW_STEPS
from orbident.estimation.output_error.sensors import joints_with_torques
from orbident.estimation.residual_checks import NOISY
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot

NEARLY = 0.9
"""Part of what explains a recording: suspects are put right to first order, so that the
true one may explain a little less than another one that is accepted."""


class Rival(NamedTuple):
    """Another cause, which was not tried, or which explains the recording as well."""

    falls: float
    """Fall of the misfit that this cause brings, or would to first order."""
    cause: str


NONE = Rival(-np.inf, "")


class Trial(NamedTuple):
    """What came of it."""

    cause: str
    accepted: bool
    misfit: float
    """Minus twice the logarithm of the likelihood, and the price."""
    estimate: Estimate | None = None
    seen: bool = False
    """Whether samples show it by themselves: then no fall in the misfit is wanted."""
    tolerable: bool = False
    """Whether the robot file can declare a tolerance that covers it."""
    rival: Rival = NONE
    """The best of the other causes that may look like it."""
    score: float | None = None
    """What it would explain to first order, where that was worked out."""
    fits: bool = False
    """Whether it is accepted, or shows too little of the mass and nothing wrong."""
    price: float = 0.0
    """What as many unknowns explain by chance (Schwarz 1978)."""

    def with_price(self, price: float) -> "Trial":
        """The trial that has to explain so much more."""
        return self._replace(misfit=self.misfit + price, price=price)

    @property
    def lost(self) -> bool:
        """Whether a search found no least cost."""
        return self.estimate is not None and not self.estimate.converged


def trial(
    cause: str,
    problem: MomentumProblem,
    free: Mapping[str, float] = NOTHING_FREE,
    likely: bool = False,
) -> Trial:
    """Identify by output error, and judge.

    Most trials explain nothing: only of one that does it is asked what else acts.

    Args:
        cause: what is put right in it.
        problem: as it would be.
        free: standard deviations beforehand of errors of instruments, by family; SI.
        likely: whether samples show it, so that it is asked in any case what else acts.
    """
    driven = joints_with_torques(problem.robot, problem.recording)
    fit = OutputError(steps=FEW_STEPS, tested=False, free=free)
    try:
        if obstacles(problem, bool(driven)):
            return Trial(cause, False, np.inf)
        spend(problem.samples.t.size)
        shown = fit.estimate(problem, lambda _: None)
    except InputError:  # Equations that overflow, or too few rows.
        return Trial(cause, False, np.inf)
    found = _judged(cause, problem, shown)
    if shown.tested and (found.accepted or found.fits or likely):
        # Where nothing is left to ask that, the cause is judged without it.
        with suppress(GivenUpError):
            return _judged(cause, problem, shown.tested())
    return found


def _judged(cause: str, problem: MomentumProblem, shown: Estimate) -> Trial:
    judgement = judge(Solved(problem, [], shown, shown), dict(shown.masses))
    accepted = worst(judgement.checks) != "do not trust"
    fits = only_vague(judgement.checks)
    return Trial(cause, accepted, misfit(shown), shown, fits=fits)


def amended_trial(
    cause: str,
    problem: MomentumProblem,
    robot: Robot | None = None,
    recording: Recording | None = None,
    likely: bool = False,
) -> Trial:
    """Identify with another robot file or recording; what is impossible fits badly."""
    try:
        return trial(cause, problem.amended(robot, recording), likely=likely)
    except InputError:
        return Trial(cause, False, np.inf)


def chi_square_left(estimate: Estimate | None) -> float:
    """Chi-square per degree of freedom; infinite without a fit."""
    goodness = estimate and estimate.goodness
    return goodness.per_dof if goodness else np.inf


def is_as_noise(estimate: Estimate | None) -> bool:
    """Whether the residuals are as small as noise."""
    return chi_square_left(estimate) < NOISY**2


def sure_trial(one: Trial, before: float) -> Trial:
    """Accepted by no chance: it explains more, or samples show it by themselves."""
    explains = one.seen or before - one.misfit > WORTH
    return one._replace(accepted=one.accepted and explains)


def best_trial(trials: list[Trial], before: float) -> Trial | None:
    """The best trial; of those that explain alike the one that was likelier.

    Its rival is another one that is accepted and explains nearly as much, or one that
    explains far more, though not all.
    """
    best = min(trials, key=rank, default=None)
    if best is None or not best.accepted:
        return best
    alike = [one for one in trials if one.misfit < best.misfit + WORTH]
    first = next(one for one in alike if one.accepted)
    # However many unknowns explain it: that one is the simpler cause makes it no fact.
    least = before - first.misfit + first.price

    def rivals(one: Trial) -> bool:
        falls = before - one.misfit + one.price
        nearly = falls > NEARLY * least
        return bool(nearly if one.accepted or one.fits else NEARLY * falls > least)

    others = [one for one in trials if one is not first and rivals(one)]
    other = min(others, key=lambda one: one.misfit, default=None)
    if other is None:
        return first
    # What is accepted explains enough.
    falls = max(before - other.misfit + other.price, least)
    return first._replace(rival=max(first.rival, Rival(falls, other.cause)))


def rank(trial: Trial) -> tuple[bool, float]:
    """The least is the best: what is accepted comes first, then the likeliest."""
    return not trial.accepted, trial.misfit
