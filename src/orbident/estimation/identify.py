"""The main job: from a robot and a recording to every free-flying parameter."""

import time
from collections.abc import Callable
from functools import cache, partial
from importlib.metadata import version
from typing import Literal, get_args

import numpy as np
from jaxtyping import Bool, Float

from orbident.errors import InputError
from orbident.estimation.clocks import base_clocks, in_words, joint_clocks
from orbident.estimation.found import Known
from orbident.estimation.least_squares import (
    INITIAL_MOMENTA,
    Fits,
    InitialMomentum,
    fit,
)
from orbident.estimation.mass import Mass, mass_of
from orbident.estimation.methods import (
    BURN,
    Applied,
    Case,
    by_least_squares,
    disagreement,
    refined,
)
from orbident.estimation.motion import motion_of
from orbident.estimation.predicted import Signals, equation_signals
from orbident.estimation.result import Estimate, Estimates, Result
from orbident.estimation.triangular import condition_numbers
from orbident.estimation.verdict import judge, obstacles
from orbident.estimation.weigh import Weighing, weigh
from orbident.model.formulas import Formulas, SetFormulas, formulas_of, mass_forms
from orbident.model.minimal_sets import MinimalSets, minimal_sets
from orbident.model.regularity import check_regular
from orbident.preprocessing.delays import corrections
from orbident.preprocessing.samples import Samples, samples_of
from orbident.preprocessing.screening import in_words as spikes_in_words
from orbident.preprocessing.screening import screened
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot
from orbident.threads import one_blas_thread

Method = Literal["maximum-likelihood", "structured", "least-squares", "recursive"]
NAN = float("nan")
NO_FORMS = Estimates((), (), np.zeros(0), np.zeros(0))
METHODS: tuple[Method, ...] = get_args(Method)


@one_blas_thread
def identify(
    robot: Robot,
    recording: Recording,
    method: Method = "maximum-likelihood",
    initial_momentum: InitialMomentum = "unknown",
    burn: Recording | None = None,
    progress: Callable[[float], object] = lambda _: None,
) -> Result:
    """Identify `pi` (Eq. 24), `phi` (Eq. 31) and the total mass (Eq. 32).

    Args:
        robot: geometry, wheels and structure; its nominal inertia is at most where a
            search starts.
        recording: of the free-floating robot.
        method: `"maximum-likelihood"` fits all sensors at once; `"structured"` the
            equations 24 and 31, for what `pi` and `phi` are made of; `"least-squares"`
            is the paper's: `pi` and `phi` each for itself, with deviations that know
            white noise only, no bias and no drift; `"recursive"` goes sample by sample,
            from CAD values that are 30 % uncertain, and watches for changes of the
            robot.
        initial_momentum: `"unknown"` estimates the momentum with `pi`; `"at-rest"`
            takes it from the wheels of a base at rest, or as zero where everything
            was at rest before the wheels spun up; `"first-sample"` subtracts the
            first sample (Eq. 24).
        burn: of the same robot, joints locked, by a known thrust: the mass that it
            tells (Eq. 40) is put beside the others. What `weigh` needs.
        progress: is called with the fraction of the samples that is done.

    Raises:
        InputError: a column is missing, there are too few samples, the nominal mass
            matrix is singular, the burn cannot be weighed, or an argument is not one
            of those named.
    """
    _check_choice("method", method, METHODS)
    _check_choice("initial momentum", initial_momentum, INITIAL_MOMENTA)
    started = time.perf_counter()
    told = _Progress(progress)
    check_regular(robot)
    weighing = None if burn is None else weigh(robot, burn)
    recording.check_joints(robot)
    clean = screened(robot, recording)
    recording = clean.recording
    sets = minimal_sets(robot)
    clocks = base_clocks(robot, recording)
    samples = samples_of(robot, recording, corrections(clocks))
    fits = fit(robot, sets, samples, initial_momentum, told.half)
    clocks |= joint_clocks(robot, sets, samples, initial_momentum)
    if "joints" in clocks and clocks["joints"].believed:
        samples = samples_of(robot, recording, corrections(clocks))
        fits = fit(robot, sets, samples, initial_momentum, told.half)
    mass = mass_of(sets, fits.pi, fits.phi)
    hindered = obstacles(robot, samples, fits, initial_momentum)
    applied = by_least_squares(sets, samples, fits, mass)
    if method != "least-squares" and not hindered.any:
        late = corrections(clocks)
        case = Case(robot, sets, recording, samples, fits, late, initial_momentum)
        applied = refined(case, method, applied, told.step, told.rest)
    verdict = judge(robot, samples, fits, hindered, applied.found, applied.no_mass)
    words = formulas_of(robot, sets)
    masses = {**_by_burn(weighing), **applied.masses}
    return Result(
        robot=robot,
        method=method,
        initial_momentum=initial_momentum,
        status=verdict.status,
        warnings=(
            *spikes_in_words(clean.rejected),
            *in_words(clocks),
            *verdict.warnings,
            *applied.warnings,
            *(disagreement(masses) if verdict.mass else ()),
            *(() if weighing is None else (f"burn: {w}" for w in weighing.warnings)),
        ),
        mass=applied.mass if verdict.mass else Estimate(NAN, NAN),
        mass_forms=_mass_forms(sets, words, mass, masses) if verdict.mass else NO_FORMS,
        pi=_estimates(words.pi, applied.found.pi, verdict.pi),
        phi=_estimates(words.phi, applied.found.phi, verdict.phi),
        base=_estimates(words.base, applied.found.base, verdict.base),
        base_covariance=_among(applied.found.base.covariance, verdict.base),
        condition_number=_condition(fits),
        residual=applied.residual,
        biases=applied.biases,
        clocks=clocks,
        rejected=clean.rejected,
        origins=samples.origins,
        samples=fits.samples,
        elapsed_s=time.perf_counter() - started,
        versions=_versions(),
        fits=fits,
        covariance=applied.found.covariance,
        history=applied.history,
        motion=motion_of(robot, samples),
        signals=_signals(robot, sets, samples, initial_momentum, applied),
    )


def _signals(
    robot: Robot,
    sets: MinimalSets,
    samples: Samples,
    initial_momentum: InitialMomentum,
    applied: Applied,
) -> Callable[[], Signals]:
    """Of a million samples the equations' would take memory that few want."""
    if applied.signals:
        return lambda: applied.signals
    pi, phi = applied.found.pi.values, applied.found.phi.values
    return partial(
        equation_signals, robot, sets, samples, initial_momentum, pi=pi, phi=phi
    )


def _by_burn(weighing: Weighing | None) -> dict[str, Estimate]:
    if weighing is None or weighing.status == "rejected":
        return {}
    return {BURN: weighing.mass}


class _Progress:
    """Half for reading all samples, then half of the rest for every step."""

    def __init__(self, progress: Callable[[float], object]):
        self.progress, self.done = progress, 0.0

    def half(self, fraction: float) -> None:
        self.done = max(self.done, fraction / 2)
        self.progress(self.done)

    def rest(self, fraction: float) -> None:
        self.progress((1 + fraction) / 2)

    def step(self) -> None:
        self.done += (1 - self.done) / 2
        self.progress(self.done)


@cache
def _versions() -> dict[str, str]:
    return {name: version(name) for name in ("orbident", "numpy", "scipy")}


def _check_choice(what: str, found: str, choices: tuple[str, ...]) -> None:
    if found not in choices:
        raise InputError(f"{what} '{found}' is unknown; use {' or '.join(choices)}")


def _estimates(
    words: Formulas, known: Known, determined: Bool[np.ndarray, " n"]
) -> Estimates:
    # Deviations of what is known but for a cancelling unknown may round to below zero.
    std = np.sqrt(np.maximum(np.diag(known.covariance), 0.0))
    return Estimates(
        names=words.names,
        formulas=words.formulas,
        values=np.where(determined, known.values, NAN),
        std=np.where(determined, std, NAN),
    )


def _mass_forms(
    sets: MinimalSets, words: SetFormulas, mass: Mass, routes: dict[str, Estimate]
) -> Estimates:
    """Every form of Eq. 32, then every route where there are several."""
    forms = mass_forms(sets, mass.forms, words)
    several = routes if len(routes) > 1 else {}
    return Estimates(
        names=(
            *(f"M from {name}" for name in forms.names),
            *(f"M by {route}" for route in several),
        ),
        formulas=(*forms.formulas, *("" for _ in several)),
        values=np.array([*mass.values, *(M.value for M in several.values())]),
        std=np.array([*mass.stds, *(M.std for M in several.values())]),
    )


def _among(
    covariance: Float[np.ndarray, "n n"], determined: Bool[np.ndarray, " n"]
) -> Float[np.ndarray, "n n"]:
    return np.where(np.outer(determined, determined), covariance, NAN)


def _condition(fits: Fits) -> dict[str, float]:
    Y, Y_normalised = condition_numbers(fits.pi.factor)
    W, W_normalised = condition_numbers(fits.phi.factor)
    return {
        "Y": Y,
        "Y_normalised": Y_normalised,
        "W": W,
        "W_normalised": W_normalised,
    }
