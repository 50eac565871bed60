"""May the numbers be trusted? Every rule of acceptance is one check."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool

from orbident.environment.agents import AGENTS, PUSH, SLOW
from orbident.estimation.checks import Check, Level
from orbident.estimation.estimate import Estimate, Solved
from orbident.estimation.momentum_problem import MomentumProblem
from orbident.estimation.obstacles import no_velocity, scale_beside_nominal, surprise
from orbident.estimation.output_error.acting import LONGEST
from orbident.estimation.output_error.joint_laws import turned_by, what_swings
from orbident.estimation.output_error.torques import possible_motors
from orbident.estimation.parameter_checks import (
    agreement_of_routes,
    long_enough,
    mass_checks,
    positive_energy,
    possible_numbers,
    size_of_pi,
)
from orbident.estimation.quantities import Quantity
from orbident.estimation.recursive.history import changes_in_words
from orbident.estimation.residual_checks import CAUSES, NOISY, residual_checks
from orbident.files.names import joined, listed

# Deviations between two estimates of the same recording that are no chance.
FAR = 3.0
# A thruster that gives less than this part of its thrust, either way, may be dead.
HALF = 0.5
# So many neighbours are named; more are given by the first and the last.
LISTED = 20
# So many sizes of what acts from outside are written out.
FEW = 4


class Judgement(NamedTuple):
    """The checks, and which numbers stand."""

    checks: tuple[Check, ...]
    pi: Bool[np.ndarray, " pi"]
    phi: Bool[np.ndarray, " phi"]
    base: Bool[np.ndarray, " beta"]


def judge(solved: Solved, masses: dict[str, Quantity]) -> Judgement:
    """Apply every rule.

    Args:
        solved: an estimate, and what the sensors show.
        masses: by every route.
    """
    problem, hindered, estimate, shown = solved[:4]
    robot = problem.robot
    names = {check.name for check in hindered}
    found, none = estimate.parameters, not hindered
    tracked = problem.samples.tracked
    pi = found.pi.determined & (not names & {"scale", "at rest"})
    # Momentum alone shows `pi`, of which there may be several robots.
    phi = found.phi.determined & tracked
    base = found.base.determined & none & tracked
    checks = [*hindered]
    if "scale" not in names:
        checks += _determined(problem, "pi", pi) if pi.any() or none else []
        checks += surprise(problem)
    if tracked:
        checks += _determined(problem, "phi", phi)
    elif none:
        checks += no_velocity(problem, "with care" if pi.any() else "do not trust")
    if none:
        checks += [
            *what_swings(
                robot.passive,
                estimate.springs,
                estimate.carried,
                turned_by(robot, problem.samples.locked),
            ),
            *_convergence(problem, estimate, shown or estimate),
            *unsettled_weights(shown or estimate),
            *residual_checks(problem, shown or estimate),
            *_agreement(solved),
            *(
                mass_checks(problem, estimate, shown or estimate)
                if tracked
                else size_of_pi(estimate)
            ),
            *positive_energy(problem, found.base, (shown or estimate).drives),
            *_changes(estimate),
            *_disturbances(estimate, problem),
            *_thrusters(shown or estimate),
            *_two_explanations(problem, shown or estimate),
            *_at_rest(shown or estimate),
            *_weighed(shown or estimate),
            *possible_motors((shown or estimate).drives),
            *_what_may_act(shown or estimate, problem),
            *agreement_of_routes(masses),
            *scale_beside_nominal(solved),
            *possible_numbers(estimate, tracked),
        ]
    return Judgement(tuple(checks), pi, phi, base)


def _determined(
    problem: MomentumProblem, name: str, determined: Bool[np.ndarray, " n"]
) -> Iterator[Check]:
    which = np.flatnonzero(~determined) + 1
    locked = [x for x in problem.samples.locked if x not in problem.robot.passive]
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


def _convergence(
    problem: MomentumProblem, estimate: Estimate, shown: Estimate
) -> Iterator[Check]:
    if estimate.converged and shown.converged:
        return
    reason, remedy = "the estimate still changes from step to step", CAUSES
    goodness, mass = shown.goodness, shown.mass
    small = goodness is not None and goodness.per_dof < NOISY**2
    if small and not shown.converged:
        reason = "residuals are as small as noise, and hardly show what still changes"
        longer = long_enough(problem, mass.value, mass.std)
        remedy = f"record a richer or longer motion{longer}"
    yield Check(
        "convergence", "do not trust", f"the fit did not converge: {reason}", remedy
    )


def _agreement(solved: Solved) -> Iterator[Check]:
    """Whether a method's own deviations hold what the sensors show."""
    shown, off = solved.shown, solved.off
    if shown is None or shown is solved.estimate:
        return
    far = off > FAR
    level: Level = "with care" if far else "trust"
    reason = (
        f"the parameters are up to {off:.2g} of this method's own deviations from "
        "those that all sensors show together"
    )
    remedy = (
        "its deviations were widened by the differences: identify by "
        "maximum-likelihood for narrower ones"
    )
    yield Check("agreement", level, reason, remedy if far else "", off, FAR)


def _changes(estimate: Estimate) -> Iterator[Check]:
    history = estimate.history
    for words in changes_in_words(history.changes) if history else ():
        yield Check("changes", "with care", words)


def _two_explanations(problem: MomentumProblem, shown: Estimate) -> Iterator[Check]:
    """A clock that seems late and a slow torque may both stand for something else."""
    slow = {*shown.unexpected} & {*SLOW}
    if problem.late and slow:
        yield Check(
            "clock and torque",
            "do not trust",
            "the recording fits only with a clock corrected and with a torque that "
            "changes slowly: together they can follow what is neither",
            f"if such a torque acts, say so (--disturbance {min(slow)}); if the clock "
            "is late, declare its latency in the robot file; else see that wheel "
            "speeds were measured and not commanded only",
        )


def _at_rest(shown: Estimate) -> Iterator[Check]:
    """Whether the robot was as still as it was said to be."""
    if shown.rest.is_no_chance("disturbance"):
        yield Check(
            "at rest",
            "do not trust",
            "more momentum was there from the start than a robot that is held at rest "
            f"has: by {shown.rest.value**0.5:.2g} of its deviations",
            "say how still it is held (at_rest in the robot file), or use "
            "--initial-momentum unknown",
        )


def _weighed(shown: Estimate) -> Iterator[Check]:
    """Whether what was weighed is of this robot."""
    if shown.weighed.is_no_chance("other parameters"):
        yield Check(
            "known",
            "do not trust",
            "what was weighed (known in the robot file) is not what the recording "
            f"shows: by {shown.weighed.value**0.5:.2g} of their deviations",
            "see that the same load and fuel were weighed, and check what gives the "
            "recording its scale, such as the wheels' inertia",
        )


def _what_may_act(estimate: Estimate, problem: MomentumProblem) -> Iterator[Check]:
    """What the deviations hold, and what it costs to know no more."""
    rows = problem.samples.t.size
    if rows > LONGEST and problem.robot.disturbances is None:
        yield Check(
            "what may act",
            "with care",
            f"what may act from outside is in no deviation: the recording has {rows} "
            f"rows, of at most {LONGEST} in which it can be estimated",
            "identify a part of the recording (--from, --to), or say that nothing "
            "acts (disturbances: [] in the robot file)",
        )
    elif estimate.allowed:
        names = listed([name.replace("_", " ") for name in estimate.allowed])
        yield Check(
            "what may act",
            "trust",
            f"deviations hold what may act ({names}): they are "
            f"{estimate.widened_by:.3g} times as wide as if nothing did",
        )


def _disturbances(estimate: Estimate, problem: MomentumProblem) -> Iterator[Check]:
    """What acts: care is needed where it is more than may act."""
    fits, pushed = estimate.disturbances, problem.samples.pushed
    for group in dict.fromkeys(fit.group for fit in fits.values()):
        own = {name: fit for name, fit in fits.items() if fit.group == group}
        largest = max(own.values(), key=lambda fit: abs(fit.value))
        sizes = f"up to {abs(largest.value):.2g} {largest.unit}"
        if len(own) <= FEW:
            sizes = ", ".join(
                f"{name} = {fit.value:.3g} +- {fit.std:.1g} {fit.unit}"
                for name, fit in own.items()
            )
        unseen = all(abs(fit.value) < fit.std for fit in own.values())
        more = group in estimate.unexpected or group == PUSH
        words = AGENTS[group].words
        if group == PUSH and pushed:
            begin, end = pushed
            words = f"something pushed between t = {begin:.4g} and {end:.4g} s"
        yield Check(
            f"{group} from outside",
            "with care" if more else "trust",
            f"{words}{', if any' if unseen else ''}: {sizes}; it was "
            f"identified with the parameters{_without(largest.shift)}",
            _remedy(group) if more else "",
        )


def _without(shift: float) -> str:
    """What it would cost to leave a disturbance out, where that is known.

    Args:
        shift: how far that would move the parameter that moves most, in deviations.
    """
    if np.isnan(shift):
        return ""
    much = f"{shift:.2g} sigmas" if np.isfinite(shift) else "much"
    return f", one of which would be off by {much} without it"


def _thrusters(estimate: Estimate) -> Iterator[Check]:
    """Thrusters that are dead, or whose gain is further off than it may be."""
    for name, fit in estimate.calibration.items():
        share, subject = 1 + fit.value, name.removesuffix(".gain").replace(".", " ")
        far = fit.value < -FAR * fit.std
        dead = far and -HALF < share < min(FAR * fit.std, HALF)
        if not name.endswith(".gain") or not (dead or np.isnan(fit.tolerance)):
            continue
        given = f"{share:.2f} +- {fit.std:.1g} of what is recorded"
        does = f"gives {given}"
        if dead:
            does = f"gives no thrust ({given})"
        elif share < -HALF:
            does = f"acts the other way: it {does}"
        elif share < 1:
            does = f"is weak: it {does}"
        yield Check(
            name,
            "with care",
            f"{subject} {does}; it was identified with the parameters",
            "look at its valve, supply and wiring, its number among the columns, and "
            "its direction and thrust in the robot file",
        )


def _remedy(group: str) -> str:
    if group == PUSH:
        return ""
    said = f"if it acts, say so in the robot file (disturbances: [{group}])"
    first = AGENTS[group].remedy
    return f"{first}; {said}" if first else said


def unsettled_weights(estimate: Estimate) -> list[Check]:
    """What it means that noise and outliers still differ from round to round."""
    if estimate.settled:
        return []
    return [
        Check(
            "weights",
            "with care",
            "the noise of the sensors, or which samples are outliers, still changed in "
            "the last round of the fit, so the estimates may change by a part of "
            "their deviations",
            "declare the noise of the sensors in the robot file, and look for outliers "
            "and drifts in the residuals",
        )
    ]
