"""What the sensors show, by output error, on the clock that explains them best.

Residuals of Eqs. 24 and 31 hide what sensors are made of, so no method is judged by
them alone. Output error predicts every sensor; a result of another method is as far
from the truth as it is from that fit, and its deviations say so.

The clock of joints and wheels is an unknown like others, `joints.clock`, to first
order. Where its score says that it is late it is freed, and samples are derived again
on the clock that was found, until no more than first order is left. What is too far for
that is first looked for by the residuals of Eq. 24.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from orbident.errors import InputError
from orbident.estimation.estimate import Estimate, Estimator, Progress
from orbident.estimation.momentum_problem import MomentumProblem, on_clocks
from orbident.estimation.output_error.estimator import OutputError
from orbident.estimation.output_error.hypotheses import FEW_STEPS
from orbident.estimation.residual_checks import residual_checks
from orbident.preprocessing.delays import LEAST, LONGEST, SURE, Delay

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

FAR = np.array([0.05, 0.1, 0.2, 0.4, 0.7, 1.0, 1.5, 2.0, 3.0])
"""s: where it is looked for; the delay between is found from the nearest of these."""

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
    shown = fit.estimate(part, progress)
    clock = _clock_of(problem, part, shown, fit, progress)
    if clock is None:
        return Evidence(problem, shown)
    if not clock.believed:
        clocks = {**problem.clocks, "joints": clock}
        return Evidence(replace(problem, clocks=clocks), shown)
    problem = _behind(problem, clock)
    if problem.exact and not whole:
        return Evidence(problem, None)
    part = problem if whole else problem.beginning(MOST)
    return Evidence(problem, fit.estimate(part, progress))


def _clock_of(
    problem: MomentumProblem,
    part: MomentumProblem,
    shown: Estimate,
    fit: OutputError,
    progress: Progress,
) -> Delay | None:
    """How late joints and wheels are; None where nothing shows their clock.

    Args:
        problem: as it is fitted.
        part: of it, which is fitted.
        shown: by it.
        fit: finds the least cost.
        progress: as `evidence` has it.
    """
    if shown.sensitivity is None or CLOCK in shown.calibration:
        return None
    alone = shown.sensitivity().alone
    if CLOCK not in alone or not np.isfinite(alone[CLOCK].std[0]):
        return None
    (late,), (std,), fall = alone[CLOCK]
    punctual = Delay(float(late), float(std), believed=False)
    likeliest = fall > WORTH and fall == max(each.fall for each in alone.values())
    if problem.extent or (shown.converged and not likeliest):
        return punctual
    start = punctual if shown.converged else _far(part)
    if abs(start.late) > LONGEST:
        return start._replace(apart=not shown.converged)
    found = _settled(part, start, replace(fit, steps=FEW_STEPS), progress)
    if found is None or misfit(found.shown) > misfit(shown) - WORTH:
        return punctual
    # A clock that does not explain the recording may stand for what is wrong.
    checks = residual_checks(found.problem, found.shown)
    fits = all(check.level != "do not trust" for check in checks)
    return found.clock if fits else punctual


class _Settled(NamedTuple):
    clock: Delay
    problem: MomentumProblem
    shown: Estimate


def _settled(
    problem: MomentumProblem, clock: Delay, fit: OutputError, progress: Progress
) -> _Settled | None:
    """The clock that is freed again and again, where that comes to an end.

    Args:
        problem: as it was recorded.
        clock: where the search starts.
        fit: finds the least cost.
        progress: as `evidence` has it.
    """
    for _ in range(ROUNDS if clock.late else 0):
        try:
            there = _behind(problem, clock._replace(believed=True))
            shown = fit.estimate(there, progress)
        except InputError:  # Too little is left where all clocks show something.
            return None
        error = shown.calibration[CLOCK]
        clock = Delay(clock.late + error.value, error.std, True)
        if not shown.converged or abs(clock.late) > LONGEST:
            return None
        if abs(error.value) < max(SETTLED, error.std):
            matters = abs(clock.late) > max(LEAST, SURE * clock.std)
            return _Settled(clock, there, shown) if matters else None
    return None


def _behind(problem: MomentumProblem, clock: Delay) -> MomentumProblem:
    return on_clocks(problem, {**problem.clocks, "joints": clock})


def _far(problem: MomentumProblem) -> Delay:
    """Where Eq. 24 fits far better; no delay where it does nowhere."""
    part, nothing = problem.beginning(ROWS), Delay(0.0, np.inf, believed=False)

    def left(late: float) -> float:
        try:
            pi = _behind(part, Delay(late, np.inf, True)).fits.pi
        except InputError:
            return np.inf
        return pi.unexplained / max(np.hypot(pi.explained, pi.unexplained), TINY)

    most = LONGEST_PART * np.ptp(part.samples.t)
    grid = np.array([-most, *-FAR[::-1], 0.0, *FAR, most])
    grid = np.unique(grid[np.abs(grid) <= most])
    values = [left(late) for late in grid]
    k = int(np.argmin(values))
    if k in {0, grid.size - 1} or values[k] ** 2 > HELPS * left(0.0) ** 2:
        return nothing
    ends, precise = (grid[k - 1], grid[k + 1]), {"xatol": LEAST}
    found = minimize_scalar(left, bounds=ends, method="bounded", options=precise)
    return nothing._replace(late=float(found.x))


def misfit(shown: Estimate) -> float:
    """Minus twice the logarithm of the likelihood, each sensor's noise at its best."""
    left = (each.measured - each.predicted for each in shown.signals)
    return sum(r.size * np.log(np.mean(r**2)) for r in left if r.any())
