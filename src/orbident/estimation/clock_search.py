"""What the sensors show, by output error, on the clock that explains them best.

Residuals of Eqs. 24 and 31 hide what sensors are made of, so no method is judged by
them alone. Output error predicts every sensor; a result of another method is as far
from the truth as it is from that fit, and its deviations say so.

The clock of joints and wheels is an unknown like others, `joints.clock`, to first
order. Where its score says that it is late it is freed, and samples are derived again
on the clock that was found, until no more than first order is left. What is too far for
that is first looked for by the residuals of Eq. 24.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import cache, lru_cache
from typing import NamedTuple

import numpy as np
from scipy.optimize import fminbound

from orbident.errors import InputError
from orbident.estimation.estimate import Estimate, Estimator, Progress
from orbident.estimation.momentum_problem import MomentumProblem, on_clocks
from orbident.estimation.output_error.estimator import OutputError
from orbident.estimation.output_error.hypotheses import FURTHER
from orbident.estimation.output_error.least_cost import FEW_STEPS
from orbident.estimation.residual_checks import leaves_nothing
from orbident.preprocessing.delays import EXPLAINED, LEAST, LONGEST, SURE, Delay

MOST = 2**13
"""Samples of a recording that other methods are judged by: its beginning. A longer one
is what they are for."""

WORTH = 25.0
"""Fall in chi-square, five deviations squared, that a clock's correction must bring."""

CLOCK = "joints.clock"

SETTLED = 1e-6
"""s: changes of the clock below this are none."""

ROUNDS = 6  # of a search that converges as Newton's does; more find nothing

ROWS = 1000
"""So many samples from the beginning of a recording show a clock that is far off."""

FAR = np.array([0.03, 0.06, *np.arange(0.1, 1.0, 0.1), 1.0, 1.25, 1.5, 2.0, 2.5, 3.0])
"""s: where it is looked for; the delay between is found from the nearest of these. They
are 0.1 s apart, as a clock that is farther off hides what an arm's motion explains."""

LONGEST_PART = 0.25
"""Of the time that is looked at: too little would be left for both clocks to show."""

TINY = 1e-300  # nothing is divided by zero

HELPS = 0.5
"""Part of the squared residuals of Eq. 24 that a clock that is far off must leave at
most: a few parameters more explain nearly as much of nonsense."""


class Evidence(NamedTuple):
    """A problem on the clocks that explain its sensors best."""

    problem: MomentumProblem
    shown: Estimate | None
    """The estimate by output error; None for exact recordings, which need none."""


class Fit(NamedTuple):
    """A problem, and the estimate by output error."""

    problem: MomentumProblem
    shown: Estimate


class _Settled(NamedTuple):
    clock: Delay
    fit: Fit


def evidence(
    problem: MomentumProblem, estimator: Estimator, progress: Progress
) -> Evidence:
    """Fit the sensors.

    Args:
        problem: of a recording.
        estimator: all samples count where it is output error itself.
        progress: is called with the fraction of the work that is done.
    """
    whole = isinstance(estimator, OutputError)
    if problem.exact and not whole:
        return Evidence(problem, None)
    fit = estimator if isinstance(estimator, OutputError) else OutputError()
    part = problem if whole else problem.beginning(MOST)
    first = Fit(part, fit.estimate(part, progress))
    # Of a recording that was read whole the clock was settled by its digest.
    if problem.extent:
        return Evidence(problem, first.shown)
    clock, found = _clock_of(first, fit, progress)
    if clock is not None:
        problem = _with(problem, clock)
    return Evidence(problem, None if problem.exact and not whole else found.shown)


def _with(problem: MomentumProblem, clock: Delay) -> MomentumProblem:
    """The problem on this clock of joints and wheels, where it is believed."""
    clocks = {**problem.clocks, "joints": clock}
    if not clock.believed:
        return replace(problem, clocks=clocks)
    return on_clocks(problem, clocks)


def _clock_of(
    first: Fit, fit: OutputError, progress: Progress
) -> tuple[Delay | None, Fit]:
    """How late joints and wheels are, and the fit on that clock.

    Args:
        first: the fit on the clock as it was recorded.
        fit: finds the least cost.
        progress: as `evidence` has it.
    """
    shown = first.shown
    punctual, likeliest = _seen(shown)
    if punctual is None or (shown.converged and not likeliest):
        return punctual, first
    near = shown.converged and abs(punctual.late) < LONGEST
    start = punctual if near else far_clock(first.problem)
    # A trial of few steps: where its fit is bad, it is not asked what else acts.
    plain = replace(fit, tested=False, steps=min(fit.steps, FEW_STEPS))

    @lru_cache(1)
    def plainly(late: float) -> Fit:
        there = _with(first.problem, Delay(late, np.inf, believed=True))
        return Fit(there, plain.estimate(there, progress))

    def in_full(late: float) -> Fit:
        there, shown = plainly(late)
        return Fit(there, shown.tested() if fit.tested and shown.tested else shown)

    if abs(start.late) > LONGEST:
        # Eq. 24 knows of no torque: a clock is that far off where a fit says so, too.
        there = plainly(start.late).shown
        sure = there.converged and misfit(there) < misfit(shown) - WORTH
        return start if sure else punctual, first
    # Only on the clock that settles it is it asked what else acts: that takes longest.
    settled = _settled(start, plainly)
    found = settled and _settled(settled.clock, in_full, sure=True)
    if found is None or misfit(found.fit.shown) > misfit(shown) - WORTH:
        return punctual, first
    clock = found.clock
    if abs(clock.late) > LONGEST:
        return clock._replace(believed=False, apart=True), first
    return found


def _seen(shown: Estimate) -> tuple[Delay | None, bool]:
    """The clock to first order, and whether it is likelier than any other error."""
    if CLOCK in shown.calibration:
        found = shown.calibration[CLOCK]
        sure = abs(found.value) > max(LEAST, SURE * found.std)
        return Delay(found.value, found.std, believed=False), sure
    alone = shown.sensitivity().alone if shown.sensitivity else {}
    if CLOCK not in alone or not np.isfinite(alone[CLOCK].std[0]):
        return None, False
    (late,), (std,), fall = alone[CLOCK]
    most, fit = max(each.fall for each in alone.values()), shown.goodness
    # What noise as it is declared does not explain, over that which was found.
    more = fit.dof * (1 - 1 / fit.per_dof) if fit and fit.declared else 0.0
    likeliest = WORTH < fall == most and FURTHER * fall > more
    return Delay(float(late), float(std), believed=False), likeliest


def _settled(
    clock: Delay,
    fitted: Callable[[float], Fit],
    sure: bool = False,
) -> _Settled | None:
    """The clock that is freed again and again, where that comes to an end.

    Args:
        clock: where the search starts.
        fitted: the fit on a clock that is so late, s.
        sure: whether it ends, too, with a fit that leaves something to explain: the
            clock may then stand for what is wrong.
    """
    for _ in range(ROUNDS if clock.late else 0):
        try:
            fit = fitted(clock.late)
        except InputError:  # Too little is left where all clocks show something.
            return None
        error = fit.shown.calibration[CLOCK]
        if not fit.shown.converged or (sure and not leaves_nothing(*fit)):
            return None
        if abs(error.value) < max(SETTLED, error.std):
            matters = abs(clock.late) > max(LEAST, SURE * error.std)
            clock = Delay(clock.late, error.std, believed=True)
            return _Settled(clock, fit) if matters else None
        clock = Delay(clock.late + error.value, error.std, believed=True)
    return None


def far_clock(problem: MomentumProblem) -> Delay:
    """How late joints and wheels are where Eq. 24 fits far better; else no delay."""
    part, nowhere = problem.beginning(ROWS), Delay(0.0, np.inf, believed=False)

    @cache
    def left(late: float) -> float:
        try:
            pi = _with(part, Delay(late, np.inf, True)).fits.pi
        except InputError:
            return np.inf
        return pi.unexplained / max(np.hypot(pi.explained, pi.unexplained), TINY)

    # A clock that fits far better than a little off it is right.
    if left(0.0) ** 2 < HELPS * min(left(-FAR[0]), left(FAR[0])) ** 2:
        return nowhere
    most = LONGEST_PART * np.ptp(part.samples.t)
    grid = np.array([-most, *-FAR[::-1], 0.0, *FAR, most])
    grid = np.unique(grid[np.abs(grid) <= most])
    tried = np.array([left(late) for late in grid])
    # At the ends little is left to explain; a valley is lower than what is around it.
    inside = np.arange(1, grid.size - 1)
    valleys = inside[(tried[1:-1] <= tried[:-2]) & (tried[1:-1] <= tried[2:])]
    if not valleys.size:
        return nowhere
    k = int(valleys[np.argmin(tried[valleys])])
    # What any clock explains, such as a push, no clock does.
    far = inside[(abs(inside - k) > 1) | (grid[inside] == 0)]
    elsewhere = tried[far].min()
    # The last step of the grid is several times as long as that before it.
    step = min(grid[k] - grid[k - 1], grid[k + 1] - grid[k])
    ends = grid[k] - step, grid[k] + step
    late = float(np.array(fminbound(left, *ends, xtol=LEAST / 10)))
    apart = abs(late) > LONGEST
    most = EXPLAINED if apart else HELPS
    helps = left(late) ** 2 < most * elsewhere**2
    return nowhere._replace(late=late, apart=apart) if helps else nowhere


def misfit(shown: Estimate) -> float:
    """Minus twice the logarithm of the likelihood, each sensor's noise at its best.

    What instruments are off counts over their tolerances: else a fit in which one is
    off by thirty of them would explain a recording as well as its cause does.

    No robot has a mass below zero. Such a fit counts, to first order, as the nearest
    one that a robot may have: that whose inverse of the mass is zero.
    """
    left = (each.measured - each.predicted for each in shown.signals)
    fitted = sum(r.size * np.log(np.mean(r**2)) for r in left if r.any())
    fitted += sum(
        (each.value / each.tolerance) ** 2
        for each in shown.calibration.values()
        if np.isfinite(each.tolerance)
    )
    M = shown.mass
    return fitted + (M.value / M.std) ** 2 if M.value < 0 else fitted
