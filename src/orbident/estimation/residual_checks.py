"""Do the residuals say that the model holds? Checks of them, the strictest of all."""

import re
from collections.abc import Iterator

import numpy as np

from orbident.estimation.checks import Check, Level, worst
from orbident.estimation.estimate import Estimate
from orbident.estimation.levels import limit, low_frequencies
from orbident.estimation.momentum_problem import ROUNDING, MomentumProblem
from orbident.estimation.signals import SIGNAL_UNITS, Signal
from orbident.estimation.unknowns import SPRING

TOLERANCES = "tolerances"
"""The name of the check whether instruments are within theirs."""

# Std of residuals over the declared noise: chi-square of its square is worth a word.
NOISY = 1.5

OF_GEOMETRY = re.compile(r"\.(place|direction)\.[xyz]$")
"""Names of errors of where a joint is."""

PLAIN = 1e-3
"""Part of a signal that neither integration nor splines leave."""

TINY = 1e-300
"""A float whose inverse is finite: a signal may be zero throughout."""

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
    yield from _instruments(estimate)
    yield from _tolerances(estimate)


def leaves_nothing(problem: MomentumProblem, estimate: Estimate) -> bool:
    """Whether residuals leave nothing to explain.

    That a number is beyond its tolerance says by itself what is wrong.
    """
    checks = residual_checks(problem, estimate)
    return worst(x for x in checks if x.name != TOLERANCES) != "do not trust"


def _noise(estimate: Estimate) -> Iterator[Check]:
    """The residuals of all equations together, over their noise."""
    goodness = estimate.goodness
    if goodness is None:
        return
    size = float(np.sqrt(goodness.per_dof))
    level: Level = "with care" if size > NOISY else "trust"
    words = {"trust": "match", "with care": "are larger than"}[level]
    reason = f"the residuals {words} the noise (by a factor of {size:.2g})"
    remedy = "" if level == "trust" else REMEDY
    yield Check(FIT, level, reason, remedy, goodness.per_dof, NOISY**2)


def _exact(problem: MomentumProblem, estimate: Estimate) -> list[Check]:
    """Where residuals are no more than integration, splines and float32 leave."""
    left = [_left(signal) for signal in estimate.signals]
    shown = left and max(left) <= ROUNDING
    # The linear equations do not see all sensors.
    if not (shown or (problem.exact and max(left, default=0.0) < PLAIN)):
        return []
    return [Check(FIT, "trust", "the residuals are rounding: there is no noise")]


def _left(signal: Signal) -> float:
    """The part of a signal that is not predicted."""
    left = float(np.sqrt(np.mean((signal.measured - signal.predicted) ** 2)))
    # Of an attitude the measured one is its error, rad.
    if signal.name == "attitude" or not left:
        return left
    return left / max(float(np.sqrt(np.mean(signal.measured**2))), TINY)


def _sensors(estimate: Estimate) -> Iterator[Check]:
    """The size of the residuals of each sensor."""
    for name, fit in estimate.sensors.items():
        times = fit.noise / fit.declared
        level: Level = "with care" if times > NOISY else "trust"
        if np.isfinite(times):
            unit = SIGNAL_UNITS[name]
            reason = (
                f"noise of {name}: {fit.noise:.2g} {unit}, {times:.3g} times the "
                f"declared {fit.declared:.2g}"
            )
            remedy = "" if level == "trust" else REMEDY
            yield Check(f"noise of {name}", level, reason, remedy, times, NOISY)


def _whiteness(estimate: Estimate) -> Iterator[Check]:
    """Whether the residuals of each sensor are noise, or motion that is not modelled.

    Parameters take up what they can of an effect that is left out: what remains may be
    far below the noise, and they are off by many deviations all the same.
    """
    for signal in estimate.signals:
        found = low_frequencies(signal.measured - signal.predicted, signal.std)
        # What integration and splines leave is slow, and says nothing of the model.
        if found is None or _left(signal) <= ROUNDING:
            continue
        name = f"whiteness of {signal.name}"
        if found.ratio <= found.limit:
            reason = f"residuals of {signal.name} are white"
            yield Check(name, "trust", reason, "", *found)
            continue
        yield Check(
            name,
            "do not trust",
            f"residuals of {signal.name} are not white: at low frequencies their power "
            f"is {found.ratio:.2g} times that of white noise (limit "
            f"{found.limit:.2g}), so something is not modelled",
            f"{CAUSES}; see whether a clock is late or runs fast, and whether "
            "anything pushes the robot or is loose on it",
            *found,
        )


def _instruments(estimate: Estimate) -> Iterator[Check]:
    """Whether one instrument's error alone would explain more than chance does."""
    if estimate.sensitivity is None or not estimate.converged:
        return
    # Where joints are is no instrument's doing; it is tried where a cause is wanted.
    alone = {
        name: each
        for name, each in estimate.sensitivity().alone.items()
        if not OF_GEOMETRY.search(name)
    }
    if not alone:
        return
    most = limit("instrument", 1, len(alone))
    name = max(alone, key=lambda name: alone[name].fall)
    (value,), (std,), drop = alone[name]
    name = name.replace(".", " ")
    if not drop > most:
        reason = "no instrument's error would explain more than chance does"
        yield Check("instruments", "trust", reason, "", drop, most)
        return
    yield Check(
        "instruments",
        "do not trust",
        f"an error of {name} by {value:.2g} +- {std:.1g} (SI) would lower "
        f"chi-square by {drop:.3g}, and more than {most:.2g} is no chance: it, or "
        "something that looks like it, is not as declared",
        f"check {name}, or declare its tolerance in the robot file",
        drop,
        most,
    )


def _tolerances(estimate: Estimate) -> Iterator[Check]:
    """Whether an instrument is off by more than it may be."""
    found = {
        name: fit
        for name, fit in estimate.calibration.items()
        if np.isfinite(fit.tolerance)
    }
    if not found or not estimate.converged:
        return
    most = limit("instrument", 1, len(found))
    squares = {name: fit.beyond_tolerance for name, fit in found.items()}
    name = max(squares, key=lambda name: squares[name])
    square, fit = squares[name], found[name]
    unit = "of its logarithm" if name.endswith(SPRING) else "SI"
    name = name.replace(".", " ")
    if not square > most:
        reason = "no instrument is off by more than its tolerance says"
        yield Check(TOLERANCES, "trust", reason, "", square, most)
        return
    # What is not told of it stays at zero.
    usual = abs(fit.value) / np.sqrt(square)
    yield Check(
        TOLERANCES,
        "do not trust",
        f"{name} would be off by {fit.value:.2g} ({unit}), where its tolerance of "
        f"{fit.tolerance:.2g} lets this recording show some {usual:.1g}: it, or "
        "something that looks like it, is not as declared",
        f"check {name}, or declare a larger tolerance in the robot file",
        square,
        most,
    )
