"""What each method makes of a recording, in one form."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.estimation.found import (
    BetaEstimate,
    Found,
    found_beta,
    found_linear,
)
from orbident.estimation.least_squares import Fits, InitialMomentum, known_momentum
from orbident.estimation.mass import Mass
from orbident.estimation.maximum_likelihood import Likelihood, maximum_likelihood
from orbident.estimation.predicted import Signals
from orbident.estimation.recursive.changes import in_words
from orbident.estimation.recursive.history import History, recursive_history
from orbident.estimation.result import Estimate, nulled
from orbident.estimation.structured import Structured, beta_of_fits, structured
from orbident.estimation.verdict import no_direct_mass, no_linear_mass
from orbident.model.minimal_sets import MinimalSets
from orbident.preprocessing.histories import MEASURED
from orbident.preprocessing.samples import Samples
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot

DISAGREE = 5.0
"""Combined deviations by which two masses differ that cannot both be right,"""

MATTERS = 0.03
"""and this part of the mass: the linear one's deviation knows white noise only."""

BURN = "Eq. 40"
"""The mass by a thruster burn, among others."""

NOTHING_LEARNT = (
    "mass: the recording tells hardly more than the nominal value that the recursion "
    "starts from; record a richer or longer motion, with more momentum in the wheels"
)

UNSETTLED = (
    "structured: the estimate still changes from pass to pass; use --method "
    "maximum-likelihood, or record a richer motion"
)


@dataclass(frozen=True)
class Applied:
    """A method's estimates and what else it learnt."""

    found: Found
    mass: Estimate
    no_mass: str | None
    """Why the mass is not told; None where it is."""
    masses: dict[str, Estimate]
    """By every route."""
    biases: dict[str, dict[str, float]]
    residual: dict[str, Any]
    warnings: tuple[str, ...] = ()
    history: History | None = None
    """Of a recursion."""
    signals: Signals = ()
    """Of the sensors, where these are what is fitted."""


class Case(NamedTuple):
    """What a method is given."""

    robot: Robot
    sets: MinimalSets
    recording: Recording
    samples: Samples
    fits: Fits
    late: Mapping[str, float]
    """By sensor, by how much its clock is behind, s."""
    initial_momentum: InitialMomentum


def refined(
    case: Case,
    method: str,
    linear: Applied,
    step: Callable[[], object],
    fraction: Callable[[float], object],
) -> Applied:
    """What a method other than least squares makes of what the linear fits left.

    Args:
        case: the recording.
        method: `"structured"`, `"maximum-likelihood"` or `"recursive"`.
        linear: by least squares.
        step: is called at every step of an iteration,
        fraction: with the fraction of the samples that is done in a recursion.
    """
    robot, sets, samples = case.robot, case.sets, case.samples
    h_cm = _known(case)
    if method == "recursive":
        history = recursive_history(robot, samples, h_cm, progress=fraction)
        return _by_recursion(case, linear, history)
    start = beta_of_fits(robot, sets, case.fits)
    if method == "structured":
        return _by_structure(
            case, linear, structured(robot, sets, samples, start, h_cm)
        )
    before = _direct(case, linear, start, "structured, white noise")
    likelihood = maximum_likelihood(
        robot,
        sets,
        case.recording,
        samples,
        case.fits,
        start.values,
        case.late,
        case.initial_momentum,
        step,
    )
    return _by_likelihood(case, before, likelihood)


def by_least_squares(
    sets: MinimalSets, samples: Samples, fits: Fits, mass: Mass
) -> Applied:
    """Separate linear fits; the mass by Eq. 32."""
    M = Estimate(mass.value, mass.std)
    velocity = fits.phi.rms if samples.v_S else None
    return Applied(
        found=found_linear(sets, fits, mass),
        mass=M,
        no_mass=no_linear_mass(mass),
        masses={"Eq. 32": M},
        biases=_linear_biases(sets, samples, fits),
        residual={
            "rms": {"momentum": fits.pi.rms, "velocity": velocity},
            "chi2_per_dof": None,
        },
    )


def _known(case: Case) -> Float[np.ndarray, "3"] | None:
    """The momentum, where more than the first sample says it; N m s."""
    if case.initial_momentum != "at-rest":
        return None
    known = known_momentum(case.robot, case.sets, case.samples, "at-rest")
    return None if known is None else np.asarray(known.h)


def _by_structure(case: Case, before: Applied, structured: Structured) -> Applied:
    return replace(
        _direct(case, before, structured.estimate, "structured", structured.consistent),
        biases=_of_sensors(case, structured.biases),
        residual={**before.residual, "chi2_per_dof": structured.chi2_per_dof},
        warnings=() if structured.settled else (UNSETTLED,),
    )


def _of_sensors(
    case: Case, biases: dict[str, dict[str, float]]
) -> dict[str, dict[str, float]]:
    """Without that of a base rate which is not the gyro's own."""
    if case.samples.origins["base_rate"] == MEASURED:
        return biases
    return {name: b for name, b in biases.items() if not name.startswith("gyro")}


def _by_likelihood(case: Case, before: Applied, likelihood: Likelihood) -> Applied:
    sensors = likelihood.sensors
    return replace(
        _direct(case, before, likelihood.estimate, "maximum likelihood"),
        no_mass=likelihood.no_mass,
        biases=likelihood.biases,
        residual={
            "rms": {name: fit.rms for name, fit in sensors.items()},
            "chi2_per_dof": likelihood.chi2_per_dof,
            "sensors": {
                name: {
                    key: nulled(value) if isinstance(value, float) else value
                    for key, value in vars(fit).items()
                }
                for name, fit in sensors.items()
            },
        },
        warnings=likelihood.in_words(),
        signals=likelihood.signals,
    )


def _by_recursion(case: Case, before: Applied, history: History) -> Applied:
    """The estimate is that after the last sample."""
    nothing = np.zeros((history.beta.shape[1], 0))
    last = BetaEstimate(history.beta[-1], history.covariance, nothing)
    applied = _direct(case, before, last, "recursion", history.consistent)
    base = applied.found.base
    base = base._replace(determined=base.determined & history.determined)
    return replace(
        applied,
        found=applied.found._replace(base=base),
        no_mass=applied.no_mass or (None if history.determined[0] else NOTHING_LEARNT),
        biases=_of_sensors(case, history.biases),
        residual={
            **before.residual,
            "chi2_per_dof": float(history.nis.sum() / max(history.dof.sum(), 1.0)),
        },
        warnings=in_words(history.changes),
        history=history,
    )


def _direct(
    case: Case,
    before: Applied,
    estimate: BetaEstimate,
    route: str,
    consistent: bool = False,
) -> Applied:
    """By a method that estimates `beta`, perhaps from equations that hold."""
    M = Estimate(*estimate.mass)
    # Forms of Eq. 32 that contradict each other may do so because fits apart, with
    # white noise, are poor; or because the signals contradict each other.
    told = consistent or not np.isfinite(before.mass.value)
    contradicted = None if told else before.no_mass
    return replace(
        before,
        found=found_beta(case.robot, case.sets, estimate),
        mass=M,
        no_mass=contradicted or no_direct_mass(*estimate.mass),
        masses={**before.masses, route: M},
    )


def disagreement(masses: dict[str, Estimate]) -> tuple[str, ...]:
    """A warning where the last route's mass is none of the others'."""
    *others, (route, M) = masses.items()
    far = [
        f"{value.value:.5g} +- {value.std:.1g} kg by {name}"
        for name, value in others
        if abs(value.value - M.value)
        > max(DISAGREE * np.hypot(value.std, M.std), MATTERS * M.value)
    ]
    if not far:
        return ()
    remedy = "check the burn's force" if BURN in masses else f"weigh the robot ({BURN})"
    return (
        f"mass: {M.value:.5g} +- {M.std:.1g} kg by {route}, but {', '.join(far)}; "
        f"{remedy}, or record a richer motion",
    )


def _linear_biases(
    sets: MinimalSets, samples: Samples, fits: Fits
) -> dict[str, dict[str, float]]:
    """That of the accelerometer, where the velocity was integrated from it."""
    if not samples.drift:
        return {}
    axes = len(sets.regressors.velocity_axes)
    names = [f"accelerometer.{'xyz'[k]}" for k in sets.regressors.velocity_axes]
    values, stds = fits.phi.nuisances[axes:], fits.phi.nuisances_std[axes:]
    return {
        name: {"value": float(value), "std": float(std)}
        for name, value, std in zip(names, values, stds, strict=True)
    }
