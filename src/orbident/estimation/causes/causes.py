"""Why a recording is refused: causes are tried, and what explains it is named."""

from collections.abc import Iterator

from orbident.estimation.causes.clocks import clocks
from orbident.estimation.causes.events import event
from orbident.estimation.causes.instruments import instruments
from orbident.estimation.causes.linear_test import best_convention
from orbident.estimation.causes.stale import stale
from orbident.estimation.causes.trial import Trial
from orbident.estimation.check import Check
from orbident.estimation.evidence import misfit
from orbident.estimation.solve import Solved

EXPLAINS = 100.0
"""Fall in chi-square from which on a cause is worth a word though others are left."""


def causes(solved: Solved) -> Iterator[Check]:
    """What is most likely wrong, first of all checks."""
    problem = solved.problem
    for words in stale(problem.robot, problem.recording):
        yield _found(words, "record each sample once, when it is taken")
        return
    wrong = best_convention(problem)
    if wrong is not None:
        times = f"{wrong.falls:.2g}"
        yield _found(
            f"{wrong.cause}: with that put right the residuals of Eqs. 24 "
            f"and 31 are {times} times smaller",
            "correct the recording or the robot file",
            wrong.falls,
        )
        return
    if solved.shown is None:
        return
    before = misfit(solved.shown)
    tried = [*instruments(problem), *clocks(problem)]
    best = min(tried, key=_rank, default=None)
    if best is None or not best.accepted:
        yield _found(event(problem), "identify the part that fits, or remove what acts")
    elif best.misfit < before - EXPLAINS:
        yield _found(
            f"{best.cause}: with that as an unknown the recording is accepted "
            f"(chi-square falls by {before - best.misfit:.2g})",
            "correct it, or declare its tolerance in the robot file",
            before - best.misfit,
        )


def _rank(trial: Trial) -> tuple[bool, float]:
    return not trial.accepted, trial.misfit


def _found(reason: str, remedy: str, statistic: float = float("nan")) -> Check:
    return Check("cause", "do not trust", reason, remedy, statistic)
