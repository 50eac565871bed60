"""May the numbers be trusted? Every rule of acceptance is one check."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool

from orbident.estimation.check import Check, Level
from orbident.estimation.estimate import Estimate
from orbident.estimation.obstacles import surprise, unexplained_velocity
from orbident.estimation.predicted import Signal
from orbident.estimation.problem import MomentumProblem
from orbident.estimation.quantities import Quantity
from orbident.estimation.recursive.changes import in_words
from orbident.estimation.triangular import condition_numbers
from orbident.estimation.whiteness import low_frequencies
from orbident.files.names import joined, listed

# Forms of Eq. 32 that differ by more than this do not measure one mass.
SPREAD = 0.5
# A mass is told where it is more than this part of itself from zero.
VAGUE = 0.3
# So many neighbours are named; more are given by the first and the last.
LISTED = 20
# Combined deviations by which two masses differ that cannot both be right,
DISAGREE = 5.0
# and this part of the mass: the linear one's deviation knows white noise only.
MATTERS = 0.03
# Std of residuals over the declared noise: chi-square of its square is worth a word.
NOISY = 1.5
# Residuals over the signal: what integration and float32 leave.
ROUNDING = 1e-7
# Condition number, columns scaled: three digits of the measurements are lost.
ILL = 1e3

# Chi-square of one degree of freedom that is no chance: five deviations, squared.
CLEAR = 25.0

BURN = "Eq. 40"
"""The mass by a thruster burn, among others."""

FIT = "goodness of fit"

CAUSES = (
    "check units (rad, rad/s, m/s), the robot's geometry, its wheels' inertia, and the "
    "signs and frames of wheel speeds and velocity"
)

REMEDY = "check the sensors, their frames and declared noise, and the geometry"

UNITS = {"torque": "N m", "pull": "m/s^2"}


class Judgement(NamedTuple):
    """The checks, and which numbers stand."""

    checks: tuple[Check, ...]
    pi: Bool[np.ndarray, " pi"]
    phi: Bool[np.ndarray, " phi"]
    base: Bool[np.ndarray, " beta"]


def judge(
    problem: MomentumProblem,
    hindered: list[Check],
    estimate: Estimate,
    masses: dict[str, Quantity],
) -> Judgement:
    """Apply every rule.

    Args:
        problem: of a recording.
        hindered: what about the recording itself forbids a result.
        estimate: by the method.
        masses: by every route.
    """
    names = {check.name for check in hindered}
    found, none = estimate.found, not hindered
    pi = found.pi.determined & (not names & {"scale", "at rest"})
    phi = found.phi.determined & ("velocity of S" not in names)
    base = found.base.determined & none
    checks = [*hindered]
    if "scale" not in names:
        checks += _determined(problem, "pi", pi) if pi.any() or none else []
        checks += surprise(problem)
    if "velocity of S" not in names:
        checks += _determined(problem, "phi", phi)
    if none:
        checks += [
            *_convergence(problem, estimate),
            *(
                _exact(problem, estimate)
                or [
                    *_noise(estimate),
                    *_sensors(estimate),
                    *_whiteness(estimate),
                    *(_condition(problem) if estimate.goodness is None else ()),
                ]
            ),
            # A method that predicts the sensors is judged by their residuals.
            *(() if estimate.signals else unexplained_velocity(problem)),
            *_mass(problem, estimate),
            *_changes(estimate),
            *_disturbances(estimate),
            *_routes(masses),
        ]
    return Judgement(tuple(checks), pi, phi, base)


def _determined(
    problem: MomentumProblem, name: str, determined: Bool[np.ndarray, " n"]
) -> Iterator[Check]:
    which, locked = np.flatnonzero(~determined) + 1, problem.samples.locked
    if which.size == 0:
        reason = f"all {determined.size} of {name} are determined"
        yield Check(f"{name} determined", "trust", reason)
        return
    runs = np.split(which, np.flatnonzero(np.diff(which) > 1) + 1)
    names = joined(
        f"{name}_{run[0]} to {name}_{run[-1]}"
        if run.size > LISTED
        else ", ".join(f"{name}_{k}" for k in run)
        for run in runs
    )
    if locked:
        noun, pronoun = ("joint", "it") if len(locked) == 1 else ("joints", "them")
        reason, remedy = f"{noun} {listed(locked)} never moved", f"move {pronoun}"
    else:
        reason, remedy = "the motion does not excite them", "record a richer trajectory"
    words = f"{names} not determined: {reason}"
    yield Check(f"{name} determined", "with care", words, remedy)


def _convergence(problem: MomentumProblem, estimate: Estimate) -> Iterator[Check]:
    if estimate.converged:
        return
    yield Check(
        "convergence",
        "do not trust",
        "the estimate still changes from step to step, so there is no best one near",
        CAUSES,
    )


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


def _mass(problem: MomentumProblem, estimate: Estimate) -> Iterator[Check]:
    """Whether the mass is told, and by forms that agree."""
    M, std = estimate.mass.value, estimate.mass.std
    yield from _forms(problem, estimate)
    history = estimate.history
    if history is not None and not history.determined[0]:
        yield Check(
            "mass",
            "do not trust",
            "mass: the recording tells hardly more than the nominal value that the "
            "recursion starts from",
            "record a richer or longer motion, with more momentum in the wheels",
        )
    elif not std < VAGUE * M:
        yield Check(
            "mass",
            "do not trust",
            f"mass: found {M:.4g} kg with a standard deviation of {std:.2g} kg",
            "record a richer or longer motion, with more momentum in the wheels",
            std / M,
            VAGUE,
        )


def _forms(problem: MomentumProblem, estimate: Estimate) -> Iterator[Check]:
    """Whether the forms of Eq. 32 give one mass.

    They may differ because linear fits with white noise are poor; where residuals over
    declared noise say that the equations hold, they do not count.
    """
    mass, goodness = problem.linear_mass, estimate.goodness
    if goodness is not None and goodness.declared:
        return
    if mass.value > 0 and mass.spread < SPREAD:
        return
    if len(mass.forms) == 0:
        if goodness is None:
            yield Check(
                "Eq. 32",
                "do not trust",
                "mass: no form of Eq. 32 is determined",
                "weigh the robot with a thruster burn (Eq. 40), or see the warnings "
                "above",
            )
        return
    yield Check(
        "Eq. 32",
        "do not trust",
        f"mass: the forms of Eq. 32 give {mass.values.min():.4g} to "
        f"{mass.values.max():.4g} kg",
        CAUSES,
        mass.spread,
        SPREAD,
    )


def _changes(estimate: Estimate) -> Iterator[Check]:
    history = estimate.history
    for words in in_words(history.changes) if history else ():
        yield Check("changes", "with care", words)


def _disturbances(estimate: Estimate) -> Iterator[Check]:
    for name, push in estimate.disturbances.items():
        if push.believed:
            value, std = (
                "[" + ", ".join(f"{number:.2g}" for number in numbers) + "]"
                for numbers in (push.value, push.std)
            )
            yield Check(
                f"{name} from outside",
                "with care",
                f"{name} from outside: found {value} +- {std} {UNITS[name]}, inertial "
                "axes; estimated with the rest",
            )


def _routes(masses: dict[str, Quantity]) -> Iterator[Check]:
    """Whether the last route's mass is one of the others'."""
    *others, (route, M) = masses.items()
    if not others:
        return
    far = [
        f"{value.value:.5g} +- {value.std:.1g} kg by {name}"
        for name, value in others
        if abs(value.value - M.value)
        > max(DISAGREE * np.hypot(value.std, M.std), MATTERS * M.value)
    ]
    if not far:
        reason = f"{len(masses)} routes to the mass agree"
        yield Check("routes to the mass", "trust", reason)
        return
    remedy = "check the burn's force" if BURN in masses else f"weigh the robot ({BURN})"
    yield Check(
        "routes to the mass",
        "with care",
        f"mass: {M.value:.5g} +- {M.std:.1g} kg by {route}, but {', '.join(far)}",
        f"{remedy}, or record a richer motion",
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
