"""The main job: from a robot and a recording to every free-flying parameter."""

import time
from collections.abc import Callable
from importlib.metadata import version
from typing import Any, Literal, get_args

import numpy as np
from jaxtyping import Bool, Float

from orbident.dynamics.regularity import check_regular
from orbident.errors import InputError
from orbident.estimation.clocks import base_clocks, in_words, joint_clocks
from orbident.estimation.least_squares import (
    INITIAL_MOMENTA,
    Fits,
    InitialMomentum,
    fit,
)
from orbident.estimation.mass import Mass, mass_of
from orbident.estimation.propagation import base_parameters
from orbident.estimation.result import Estimate, Estimates, Result
from orbident.estimation.triangular import LinearFit, condition_numbers
from orbident.estimation.verdict import judge
from orbident.precision import in_float64
from orbident.recordings.recording import Recording
from orbident.regressors.formulas import Formulas, SetFormulas, formulas_of, mass_forms
from orbident.regressors.minimal_sets import MinimalSets, minimal_sets
from orbident.robot.description import Robot
from orbident.signals.delays import corrections
from orbident.signals.samples import Samples, samples_of
from orbident.signals.screening import in_words as spikes_in_words
from orbident.signals.screening import screened

Method = Literal["least-squares"]
NAN = float("nan")
METHODS: tuple[Method, ...] = get_args(Method)


@in_float64
def identify(
    robot: Robot,
    recording: Recording,
    method: Method = "least-squares",
    initial_momentum: InitialMomentum = "unknown",
    progress: Callable[[float], object] = lambda _: None,
) -> Result:
    """Identify `pi` (Eq. 24), `phi` (Eq. 31) and the total mass (Eq. 32).

    Args:
        robot: geometry, wheels and structure; its nominal inertia is not used.
        recording: of the free-floating robot.
        method: `"least-squares"`.
        initial_momentum: `"unknown"` estimates the momentum with `pi`; `"at-rest"`
            takes it from the wheels of a base at rest, or as zero where everything
            was at rest before the wheels spun up; `"first-sample"` subtracts the
            first sample (Eq. 24).
        progress: is called with the fraction of the samples that is done.

    Raises:
        InputError: a column is missing, there are too few samples, the nominal mass
            matrix is singular, or an argument is not one of those named.
    """
    _check_choice("method", method, METHODS)
    _check_choice("initial momentum", initial_momentum, INITIAL_MOMENTA)
    started = time.perf_counter()
    check_regular(robot)
    recording.check_joints(robot)
    clean = screened(robot, recording)
    recording = clean.recording
    sets = minimal_sets(robot)
    clocks = base_clocks(robot, recording)
    samples = samples_of(robot, recording, corrections(clocks))
    fits = fit(robot, sets, samples, initial_momentum, progress)
    clocks |= joint_clocks(robot, sets, samples, initial_momentum)
    if "joints" in clocks and clocks["joints"].believed:
        samples = samples_of(robot, recording, corrections(clocks))
        fits = fit(robot, sets, samples, initial_momentum, progress)
    mass = mass_of(sets, fits.pi, fits.phi)
    verdict = judge(robot, samples, fits, mass, initial_momentum)
    known = verdict.pi, verdict.phi, verdict.mass
    base = base_parameters(sets, fits.pi, fits.phi, mass, known)
    words = formulas_of(robot, sets)
    return Result(
        robot=robot,
        method=method,
        initial_momentum=initial_momentum,
        status=verdict.status,
        warnings=(
            *spikes_in_words(clean.rejected),
            *in_words(clocks),
            *verdict.warnings,
        ),
        mass=Estimate(mass.value, mass.std) if verdict.mass else Estimate(NAN, NAN),
        mass_forms=_mass_forms(sets, words, mass, verdict.mass),
        pi=_estimates(words.pi, fits.pi.values, _std(fits.pi), verdict.pi),
        phi=_estimates(words.phi, fits.phi.values, _std(fits.phi), verdict.phi),
        base=_estimates(words.base, base.values, base.std, base.determined),
        condition_number=_condition(fits),
        residual=_residual(fits, has_velocity=bool(samples.v_S)),
        biases=_biases(sets, samples, fits),
        clocks=clocks,
        rejected=clean.rejected,
        origins=samples.origins,
        samples=fits.samples,
        elapsed_s=time.perf_counter() - started,
        versions={name: version(name) for name in ("orbident", "jax", "numpy")},
        fits=fits,
    )


def _check_choice(what: str, found: str, choices: tuple[str, ...]) -> None:
    if found not in choices:
        raise InputError(f"{what} '{found}' is unknown; use {' or '.join(choices)}")


def _std(fit: LinearFit) -> Float[np.ndarray, " n"]:
    return np.sqrt(np.diag(fit.covariance))


def _estimates(
    words: Formulas,
    values: Float[np.ndarray, " n"],
    std: Float[np.ndarray, " n"],
    determined: Bool[np.ndarray, " n"],
) -> Estimates:
    return Estimates(
        names=words.names,
        formulas=words.formulas,
        values=np.where(determined, values, NAN),
        std=np.where(determined, std, NAN),
    )


def _mass_forms(
    sets: MinimalSets, words: SetFormulas, mass: Mass, known: bool
) -> Estimates:
    count = len(mass.forms) if known else 0
    forms = mass_forms(sets, mass.forms[:count], words)
    return Estimates(
        names=tuple(f"M from {name}" for name in forms.names),
        formulas=forms.formulas,
        values=mass.values[:count],
        std=mass.stds[:count],
    )


def _biases(
    sets: MinimalSets, samples: Samples, fits: Fits
) -> dict[str, dict[str, Any]]:
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


def _condition(fits: Fits) -> dict[str, float]:
    Y, Y_normalised = condition_numbers(fits.pi.factor)
    W, W_normalised = condition_numbers(fits.phi.factor)
    return {
        "Y": Y,
        "Y_normalised": Y_normalised,
        "W": W,
        "W_normalised": W_normalised,
    }


def _residual(fits: Fits, has_velocity: bool) -> dict[str, Any]:
    """RMS per equation: momentum in N m s, velocity in m/s."""
    rms = {
        "momentum": fits.pi.rms,
        "velocity": fits.phi.rms if has_velocity else None,
    }
    return {"rms": rms, "chi2_per_dof": None}
