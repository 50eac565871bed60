"""Do the residuals say that the model holds? Checks of them, the strictest of all."""

from collections.abc import Iterator

import numpy as np

from orbident.estimation.check import Check, Level
from orbident.estimation.estimate import Estimate
from orbident.estimation.predicted import Signal
from orbident.estimation.problem import MomentumProblem
from orbident.estimation.triangular import condition_numbers
from orbident.estimation.whiteness import low_frequencies

# Std of residuals over the declared noise: chi-square of its square is worth a word.
NOISY = 1.5
# Residuals over the signal: what integration and float32 leave.
ROUNDING = 1e-7
# Condition number, columns scaled: three digits of the measurements are lost.
ILL = 1e3
# Chi-square of one degree of freedom that is no chance: five deviations, squared.
CLEAR = 25.0

FIT = "goodness of fit"

CAUSES = (
    "check units (rad, rad/s, m/s), the robot's geometry, its wheels' inertia, and the "
    "signs and frames of wheel speeds and velocity"
)

REMEDY = "check the sensors, their frames and declared noise, and the geometry"


def residual_checks(problem: MomentumProblem, estimate: Estimate) -> Iterator[Check]:
    """Size and whiteness of the residuals; one check where they are rounding."""
    exact = _exact(problem, estimate)
    if exact:
        yield from exact
        return
    yield from _noise(estimate)
    yield from _sensors(estimate)
    yield from _whiteness(estimate)
    if estimate.goodness is None:
        yield from _condition(problem)


def _noise(estimate: Estimate) -> Iterator[Check]:
    """The residuals of all equations together, over their noise."""
    name, goodness = FIT, estimate.goodness
    if goodness is None:
        yield Check(
            name,
            "with care",
            "least squares takes the noise for white and the regressors for exact, so "
            "its intervals are too narrow",
            "identify by maximum-likelihood, which says by how much",
        )
        return
    size = float(np.sqrt(goodness.per_dof))
    level: Level = "with care" if size > NOISY else "trust"
    reason = f"residuals are {size:.2g} times as large as the noise"
    remedy = "" if level == "trust" else REMEDY
    yield Check(name, level, reason, remedy, goodness.per_dof, NOISY**2)


def _exact(problem: MomentumProblem, estimate: Estimate) -> list[Check]:
    """Where residuals are no more than integration, splines and float32 leave."""
    fits = problem.fits.pi, problem.fits.phi
    rounded = all(fit.unexplained <= ROUNDING * fit.explained for fit in fits)
    shown = estimate.signals and all(_is_rounding(s) for s in estimate.signals)
    if not (rounded or shown):
        return []
    return [Check(FIT, "trust", "the residuals are rounding: there is no noise")]


def _is_rounding(signal: Signal) -> bool:
    left = np.sqrt(np.mean((signal.measured - signal.predicted) ** 2))
    # Of an attitude the measured one is its error, rad.
    of = 1.0 if signal.name == "attitude" else np.sqrt(np.mean(signal.measured**2))
    return bool(left <= ROUNDING * of)


def _sensors(estimate: Estimate) -> Iterator[Check]:
    """The size of the residuals of each sensor."""
    for name, fit in estimate.sensors.items():
        times = fit.noise / fit.declared
        level: Level = "with care" if times > NOISY else "trust"
        if np.isfinite(times):
            reason = (
                f"{name}: its noise is {times:.2g} times what the robot file declares "
                f"({fit.noise:.2g} against {fit.declared:.2g})"
            )
            remedy = "" if level == "trust" else REMEDY
            yield Check(f"noise of {name}", level, reason, remedy, times, NOISY)


def _whiteness(estimate: Estimate) -> Iterator[Check]:
    """Whether the residuals of each sensor are noise, or motion that is not modelled.

    Parameters take up what they can of an effect that is left out: what remains may be
    far below the noise, and they are off by many deviations all the same.
    """
    if not estimate.signals and estimate.goodness is not None:
        yield Check(
            "whiteness",
            "with care",
            "this method does not test what each sensor shows, so an effect that is "
            "not modelled may pass unseen",
            "identify by maximum-likelihood too, which tests it",
        )
    suspect = ""
    for signal in estimate.signals:
        found = low_frequencies(signal.measured - signal.predicted, signal.std)
        if found is None:
            continue
        name = f"whiteness of {signal.name}"
        if found.ratio <= found.limit:
            reason = f"residuals of {signal.name} are white"
            yield Check(name, "trust", reason, "", *found)
            continue
        suspect = suspect or _suspect(estimate)
        yield Check(
            name,
            "do not trust",
            f"residuals of {signal.name} are not noise: at low frequencies they have "
            f"{found.ratio:.2g} times the power of white noise, and more than "
            f"{found.limit:.2g} is no chance, so something acts that is not modelled",
            f"{suspect}{CAUSES}; see whether a clock is late or runs fast, and whether "
            "anything pushes the robot or is loose on it",
            *found,
        )


def _suspect(estimate: Estimate) -> str:
    """The instrument whose error alone would lower chi-square most (score test)."""
    if estimate.sensitivity is None or not estimate.converged:
        return ""
    freed = sorted(estimate.sensitivity().freed, key=lambda each: -each.chi2_drop)
    if not freed or freed[0].chi2_drop < CLEAR:
        return ""
    first = freed[0]
    return (
        f"first look at {first.name.replace('.', ' ')}: an error of "
        f"{first.value:.2g} +- {first.std:.1g} would lower chi-square by "
        f"{first.chi2_drop:.3g}, more than that of any other instrument; "
    )


def _condition(problem: MomentumProblem) -> Iterator[Check]:
    """Noise in the regressors counts by the square of it, where it is neglected."""
    worst = max(
        condition_numbers(fit.factor)[1] for fit in (problem.fits.pi, problem.fits.phi)
    )
    level: Level = "trust" if worst < ILL else "with care"
    reason, remedy = "the motion excites all that it should tell", ""
    if worst >= ILL:
        reason, remedy = "some parameters are hardly excited", "record a richer motion"
    reason += f" (condition number {worst:.2g})"
    yield Check("excitation", level, reason, remedy, worst, ILL)
