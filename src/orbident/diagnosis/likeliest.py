"""What may be wrong, by what it would explain to first order, and a trial of it."""

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import NamedTuple

import numpy as np

from orbident.diagnosis.encoders import joint_errors, ripples
from orbident.diagnosis.filters import filters
from orbident.diagnosis.frames import beside
from orbident.diagnosis.instruments import freed, kinds
from orbident.diagnosis.jumps import steps
from orbident.diagnosis.late_clocks import SHARED, clocks, fast_clocks
from orbident.diagnosis.shifts import curved_scales, drifts, vibrations
from orbident.diagnosis.suspects import Scores, tried
from orbident.diagnosis.trial import Trial
from orbident.estimation.clock_search import WORTH
from orbident.estimation.estimate import Solved
from orbident.estimation.output_error.sensors import joints_with_torques

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
        if first.values.size:
            gain = first.fall - price * first.values.size
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
