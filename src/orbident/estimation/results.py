"""The result of an estimate and its checks."""

import platform
from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from importlib.metadata import version

import numpy as np
from jaxtyping import Bool, Float

from orbident.estimation.base_parameters import Known
from orbident.estimation.budget import Budget, SensitivityTable, budget_of
from orbident.estimation.clock_search import CLOCK
from orbident.estimation.criteria import Judgement
from orbident.estimation.estimate import BesideParameters, Estimate
from orbident.estimation.linear_fits import Fits
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.output_error.sensors import joints_with_torques
from orbident.estimation.parameter_checks import is_a_mass, sigmas_apart
from orbident.estimation.quantities import (
    NO_ROUTES,
    BaseSet,
    EstimatedSet,
    Identified,
    MassRoutes,
    Quantity,
    TotalMass,
    fields_as,
)
from orbident.estimation.result import Result
from orbident.estimation.signals import (
    Residual,
    SensorResidual,
    Signals,
    equation_signals,
)
from orbident.estimation.triangular import condition_numbers
from orbident.estimation.unknowns import DRIVE, SPRING, CalibrationFit
from orbident.estimation.weigh import Weighing
from orbident.files.json_parts import as_computed, nulled
from orbident.files.names import listed
from orbident.model.formulas import (
    Formulas,
    SetFormulas,
    formulas_of,
    mass_forms,
    nominal_parameters,
)
from orbident.preprocessing.delays import clocks_in_words
from orbident.preprocessing.extent import Extent, motion_of
from orbident.preprocessing.origins import origin_in_words
from orbident.preprocessing.screening import rejected_in_words

NAN = float("nan")


def result_of(
    problem: MomentumProblem,
    method: str,
    estimate: Estimate,
    judgement: Judgement,
    masses: dict[str, Quantity],
    weighing: Weighing | None,
    elapsed_s: float,
) -> Result:
    """Put together what was estimated and how it was judged."""
    estimate = replace(estimate, calibration=_calibration(problem, estimate))
    identified = _identified(problem, estimate, judgement, masses)
    result = Result(
        robot=problem.robot,
        method=method,
        initial_momentum=problem.initial_momentum,
        checks=judgement.checks,
        notes=(
            *problem.robot.warnings,
            *problem.notes,
            *rejected_in_words(problem.rejected),
            *clocks_in_words(problem.clocks),
            *_unused_torques(problem, method, estimate),
            *(() if weighing is None else (f"burn: {w}" for w in weighing.warnings)),
        ),
        **vars(identified),
        condition_number=_condition(problem.fits),
        residual=_residual(estimate),
        **fields_as(estimate, BesideParameters),
        sensitivity=partial(_sensitivity, estimate, identified),
        # The screen, the report and files ask for it, and it takes a tenth of the fit.
        budget=cache(partial(_budget, problem, estimate, identified)),
        clocks=problem.clocks,
        rejected=problem.rejected,
        origins={
            name: origin_in_words(origin)
            for name, origin in problem.samples.origins.items()
        },
        samples=problem.fits.samples,
        elapsed_s=elapsed_s,
        versions={**versions(), "python": platform.python_version()},
        fits=problem.fits,
        motion=motion_of(
            problem.robot,
            problem.extent or Extent.of(problem.samples),
            problem.samples.locked,
        ),
        signals=_signals(problem, estimate),
    )
    if result.status == "ok":
        return result
    # For exact data deviations are rounding, and shifts over them say nothing.
    return replace(
        result.withheld(), sensitivity=as_computed(None), budget=as_computed(None)
    )


def _identified(
    problem: MomentumProblem,
    estimate: Estimate,
    judgement: Judgement,
    masses: dict[str, Quantity],
) -> Identified:
    words, found = formulas_of(problem.robot, problem.sets), estimate.parameters
    cad = nominal_parameters(problem.robot, problem.sets)
    determined = np.outer(judgement.base, judgement.base)
    both = np.concatenate([judgement.pi, judgement.phi])
    return Identified(
        mass=TotalMass(
            estimate.mass.value,
            estimate.mass.std,
            _mass_forms(problem, words, masses, estimate.mass),
        ),
        pi=_set(words.pi, found.pi, judgement.pi, cad.pi),
        phi=_set(words.phi, found.phi, judgement.phi, cad.phi),
        base=BaseSet(
            **vars(_set(words.base, found.base, judgement.base, cad.base)),
            covariance=np.where(determined, found.base.covariance, NAN),
        ),
        covariance=np.where(np.outer(both, both), found.covariance, NAN),
    )


def _set(
    words: Formulas,
    known: Known,
    determined: Bool[np.ndarray, " n"],
    nominal: Float[np.ndarray, " n"],
) -> EstimatedSet:
    # Deviations of what is known but for a cancelling unknown may round to below zero.
    std = np.sqrt(np.maximum(np.diag(known.covariance), 0.0))
    return EstimatedSet(
        names=words.names,
        formulas=words.formulas,
        values=np.where(determined, known.values, NAN),
        std=np.where(determined, std, NAN),
        nominal=nominal,
    )


def _mass_forms(
    problem: MomentumProblem,
    words: SetFormulas,
    routes: dict[str, Quantity],
    M: Quantity,
) -> MassRoutes:
    """The forms of Eq. 32 that give a mass, then every route where there are several.

    Args:
        problem: of a recording.
        words: names of its parameters.
        routes: the mass by every route, the method's own last.
        M: the method's own.
    """
    if problem.samples.unknown_thrust:
        return NO_ROUTES
    mass = problem.linear_mass
    kept = [
        is_a_mass(value, std, M)
        for value, std in zip(mass.values, mass.stds, strict=True)
    ]
    forms = mass_forms(problem.sets, mass.forms[kept], words)
    several = routes if len(routes) > 1 else {}
    apart = [sigmas_apart(other, M) for other in several.values()]
    if several:
        apart[-1] = NAN
    return MassRoutes(
        names=(
            *(f"M from {name}" for name in forms.names),
            *(f"M by {route}" for route in several),
        ),
        formulas=(*forms.formulas, *("" for _ in several)),
        values=np.array([*mass.values[kept], *(M.value for M in several.values())]),
        std=np.array([*mass.stds[kept], *(M.std for M in several.values())]),
        sigmas=np.array([*mass.sigmas[kept], *apart]),
        left_out=len(kept) - sum(kept),
    )


def _calibration(
    problem: MomentumProblem, estimate: Estimate
) -> dict[str, CalibrationFit]:
    """Without what is said elsewhere: a clock that was corrected, springs, drives.

    Where a clock has a tolerance, it is how late the clock is in all.
    """
    apart = {
        f"joint.{name}.{what}"
        for names, of_each in (
            (problem.robot.passive, SPRING),
            (estimate.drives, DRIVE),
        )
        for name in names
        for what in of_each
    }
    found = {n: fit for n, fit in estimate.calibration.items() if n not in apart}
    known = problem.robot.tolerances.joint_clock
    late = problem.late.get("joints", 0.0)
    if late and CLOCK in found:
        rest = found.pop(CLOCK)
        if known:
            found[CLOCK] = CalibrationFit(late + rest.value, rest.std, known)
    return found


def _unused_torques(
    problem: MomentumProblem, method: str, estimate: Estimate
) -> list[str]:
    """Which torques do not count, and why; none where nothing was fitted."""
    shown = joints_with_torques(problem.robot, problem.recording)
    if method == "least-squares":
        # An ideal flight shows them of every robot.
        words = f"{method} leaves torques of joints out: other methods take them"
        return [words] if shown and problem.robot.sensors.torques else []
    left = [name for name in shown if name not in estimate.drives]
    if not left or estimate.goodness is None:
        return []
    return [
        f"torques of {listed(left)} do not count: such a joint is passive, stands, "
        "is zero throughout, moves by another one, or has gaps between its samples"
    ]


def _residual(estimate: Estimate) -> Residual:
    goodness = estimate.goodness
    found = Residual(
        rms=dict(estimate.rms),
        chi2_per_dof=None if goodness is None else goodness.per_dof,
    )
    if estimate.sensors:
        found["sensors"] = {
            name: SensorResidual(
                rms=nulled(fit.rms),
                noise=nulled(fit.noise),
                declared=nulled(fit.declared),
                whiteness=nulled(fit.whiteness),
                samples=fit.samples,
            )
            for name, fit in estimate.sensors.items()
        }
    return found


def _sensitivity(estimate: Estimate, identified: Identified) -> SensitivityTable | None:
    if estimate.sensitivity is None:
        return None
    found = estimate.sensitivity()
    if not found.names:
        return None
    shifts = found.in_deviations(np.eye(len(found.shift)))
    lost = ~np.isfinite(identified.base.values)
    return SensitivityTable(
        identified.base.names,
        found.names,
        found.units,
        np.where(lost[:, None], NAN, shifts),
    )


def _budget(
    problem: MomentumProblem, estimate: Estimate, identified: Identified
) -> Budget | None:
    if estimate.sources is None or problem.exact:
        return None
    found = identified.base, identified.phi, identified.pi
    return budget_of(
        estimate.sources(),
        tuple(name for each in found for name in each.names),
        problem.robot,
        problem.sets,
        estimate.parameters.base.values,
        np.isfinite(np.concatenate([each.values for each in found])),
    )


def _signals(problem: MomentumProblem, estimate: Estimate) -> Callable[[], Signals]:
    """A function that gives the signals.

    Where they come from the equations, those of a million samples would take memory
    that few want.
    """
    if estimate.signals:
        return lambda: estimate.signals
    return partial(
        equation_signals,
        problem.robot,
        problem.sets,
        problem.samples,
        problem.initial_momentum,
        pi=estimate.parameters.pi.values,
        phi=estimate.parameters.phi.values,
    )


def _condition(fits: Fits) -> dict[str, float]:
    Y, Y_normalised = condition_numbers(fits.pi.factor)
    W, W_normalised = condition_numbers(fits.phi.factor)
    return {
        "Y": Y,
        "Y_normalised": Y_normalised,
        "W": W,
        "W_normalised": W_normalised,
    }


@cache
def versions() -> dict[str, str]:
    """The versions of the libraries that compute in this process."""
    return {name: version(name) for name in ("orbident", "numpy", "scipy")}
