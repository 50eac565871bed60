"""May the result be trusted, and why: what a report begins with."""

from typing import Literal, NamedTuple

import numpy as np

from orbident.estimation.methods import MATTERS
from orbident.estimation.predicted import Signal, Signals
from orbident.estimation.result import Result
from orbident.report.numbers import interval, short, with_std
from orbident.report.spectra import residuals, whiteness

NOISY = 1.5
"""Residuals over the declared noise: a chi-square of its square is worth a word."""

COLOURED = 0.2
"""Correlation of neighbouring residuals that makes deviations a fifth too small."""

ROUNDING = 1e-7
"""Residuals over the signal: what integration and float32 leave."""

ILL = 1e3
"""Condition number, columns scaled: three digits of the measurements are lost."""

Level = Literal["yes", "care", "no"]

HEADLINES = {
    "yes": "Trust it",
    "care": "Trust it, with care",
    "no": "Do not trust it",
}


class Check(NamedTuple):
    """One reason for or against."""

    good: bool
    words: str


class Judgement(NamedTuple):
    """What a report says first."""

    level: Level
    headline: str
    mass: str
    """In words; empty where there is none."""
    checks: tuple[Check, ...]
    warnings: tuple[str, ...]
    """Of the identification: why, and what to do."""


def judgement(result: Result, signals: Signals) -> Judgement:
    """Judge a result by what it says of itself.

    Args:
        result: of an identification.
        signals: measured and predicted.
    """
    if result.status == "rejected":
        level, checks = "no", ()
    else:
        checks = (
            *_determined(result),
            *(_exact(signals) or [*_noise(result), *_whiteness(result, signals)]),
            *_masses(result),
            *_condition(result),
        )
        doubts = result.warnings or not all(check.good for check in checks)
        level = "care" if doubts else "yes"
    return Judgement(
        level=level,
        headline=HEADLINES[level],
        mass=mass_in_words(result),
        checks=checks,
        warnings=result.warnings,
    )


def mass_in_words(result: Result) -> str:
    """The mass with its interval."""
    M, std = result.mass.value, result.mass.std
    if not np.isfinite(M):
        return ""
    return f"{with_std(M, std)} ± {short(std, 2)} kg (95 %: {interval(M, std)} kg)"


def _determined(result: Result) -> list[Check]:
    values = np.concatenate(
        [result.base.values, result.pi.values, result.phi.values, [result.mass.value]]
    )
    lost = int((~np.isfinite(values)).sum())
    if lost:
        return [Check(False, f"{lost} of {values.size} parameters are not determined")]
    return [Check(True, f"all {values.size} parameters are determined")]


def _exact(signals: Signals) -> list[Check]:
    if not signals or any(_left(signal) > ROUNDING for signal in signals):
        return []
    return [Check(True, "the residuals are rounding: the recording has no noise")]


def _left(signal: Signal) -> float:
    """RMS of the residuals over that of the signal."""
    size = float(np.sqrt(np.mean(signal.measured**2)))
    return float(np.sqrt(np.mean(residuals(signal) ** 2))) / size if size else 0.0


def _noise(result: Result) -> list[Check]:
    chi2 = result.residual.get("chi2_per_dof")
    if chi2 is None:
        return [
            Check(
                False,
                "least squares takes the noise for white: the intervals are too narrow "
                "where signals were integrated or filtered; maximum likelihood says by "
                "how much",
            )
        ]
    size = short(float(np.sqrt(chi2)), 2)
    if chi2 > NOISY**2:
        return [Check(False, f"residuals are {size} times as large as the noise")]
    return [Check(True, f"residuals are as small as the noise ({size} times)")]


def _whiteness(result: Result, signals: Signals) -> list[Check]:
    sensors = result.residual.get("sensors", {})
    found = {name: fit["whiteness"] for name, fit in sensors.items()}
    if not found and result.residual.get("chi2_per_dof") is None:
        # The signals are those of the equations, which know no drift.
        found = {signal.name: whiteness(signal) for signal in signals}
    coloured = [name for name, r in found.items() if abs(r or 0.0) > COLOURED]
    if coloured:
        return [
            Check(
                False,
                f"residuals of {', '.join(coloured)} are not white: something is not "
                "modelled, and the intervals are too narrow",
            )
        ]
    return [Check(True, "residuals are white")] if found else []


def _masses(result: Result) -> list[Check]:
    routes = [
        value
        for name, _, value, _ in result.mass_forms
        if name.startswith("M by ") and np.isfinite(value)
    ]
    if len(routes) < 2:
        return []
    spread = (max(routes) - min(routes)) / result.mass.value
    words = f"{len(routes)} routes to the mass agree to {short(100 * spread, 2)} %"
    return [Check(spread < MATTERS, words)]


def _condition(result: Result) -> list[Check]:
    numbers = [
        result.condition_number.get(f"{name}_normalised", np.nan) for name in "YW"
    ]
    if not np.isfinite(numbers).any():
        return []
    worst = float(np.nanmax(numbers))
    good = worst < ILL
    words = "the motion excites all that it should tell"
    if not good:
        words = "some parameters are hardly excited: record a richer motion"
    return [Check(good, f"{words} (condition number {short(worst, 2)})")]
