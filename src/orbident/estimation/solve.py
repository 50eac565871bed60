"""The estimate from a robot and a recording, beside what all its sensors show.

Where the robot changes while it is recorded: when it did, and what it is after that. A
filter that learns from CAD on takes its own errors for a change now and then. All
samples between two changes, fitted at once by output error, know better: a change is
one where the robots before and after it are not the same.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache, partial

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.estimation.checks import Check
from orbident.estimation.clock_search import MOST, Evidence, Fit, evidence, misfit
from orbident.estimation.estimate import Change, Estimate, Estimator, Progress, Solved
from orbident.estimation.least_squares import LeastSquares
from orbident.estimation.levels import ChiSquare, Rule, chi_square, limit
from orbident.estimation.linear_fits import InitialMomentum
from orbident.estimation.momentum_problem import (
    MomentumProblem,
    digest_of,
    momentum_problem,
    whole,
)
from orbident.estimation.obstacles import obstacles
from orbident.estimation.output_error.estimator import OutputError
from orbident.estimation.output_error.hypotheses import FEW_STEPS
from orbident.estimation.output_error.sensors import joints_with_torques
from orbident.estimation.recursive.history import Recursive
from orbident.estimation.residual_checks import residual_checks
from orbident.estimation.widening import difference, widened
from orbident.extras import provided
from orbident.files.names import joined
from orbident.recordings.long_recording import LongRecording
from orbident.recordings.recording import Recording
from orbident.robot.description import KnownQuantities, Robot

FEWEST = 100
"""Samples of a part that output error is asked about: of fewer it learns little."""

EARLIER = 30
"""Samples before a change was found that may be after it: a filter that learns takes up
some of a change before it sees the rest."""

ANOTHER_ROBOT: Rule = "other parameters"
"""Which test says that two parts are not of one robot."""


def differing(one: Estimate, other: Estimate) -> ChiSquare:
    """How far two estimates of the base parameters are apart, as a chi-square."""
    a, b = one.parameters.base, other.parameters.base
    both = np.flatnonzero(a.determined & b.determined)
    # With their correlations: all may share a doubt about the scale.
    C = (a.covariance + b.covariance)[np.ix_(both, both)]
    return chi_square((a.values - b.values)[both], C)


def _apart(before: Fit, after: Fit) -> ChiSquare:
    """How far two parts are from being of one robot, as a chi-square.

    The least cost of a short part may lie in a curved valley: its deviations hold what
    is near, and not the robot that explains it nearly as well. So the later part is
    fitted again beside what the earlier one says, and costs more by so much.
    """
    numbers = differing(before.shown, after.shown)
    if not numbers.is_no_chance(ANOTHER_ROBOT):
        return numbers
    assert before.shown.shared is not None
    said = before.shown.shared()
    fit = OutputError(steps=FEW_STEPS, tested=False, others=said)
    both = fit.estimate(after.problem, lambda _: None)
    if not both.converged:
        return numbers
    equations = said.over(())
    off = equations[:, :-1] @ both.parameters.base.values - equations[:, -1]
    more = misfit(both) - misfit(after.shown) + float(off @ off)
    return numbers._replace(value=min(numbers.value, max(more, 0.0)))


def since_the_last_change(
    problem: MomentumProblem, suspected: Sequence[Change], progress: Progress
) -> tuple[tuple[Change, ...], Evidence]:
    """The changes that output error confirms, and what it makes of all after the last.

    There are none where one robot fits all that is left: what acts looks like a change,
    too.

    Args:
        problem: of the whole recording.
        suspected: by a filter, in their order.
        progress: is called with the fraction of the work that is done.
    """
    confirmed, begin = list[Change](), -np.inf
    between, t = cache(partial(_between, problem)), problem.recording.t
    while not between(begin, np.inf):
        progress(float(np.mean(t < begin)))
        change = _next_change(between, _apart, t, begin, suspected)
        if change is None:
            break
        confirmed.append(change)
        begin = change.t
    last = _cut(problem, begin, np.inf)
    return tuple(confirmed), evidence(last, OutputError(), progress)


def _next_change(
    between: Callable[[float, float], Fit | None],
    apart: Callable[[Fit, Fit], ChiSquare],
    t: Float[np.ndarray, " rows"],
    begin: float,
    suspected: Sequence[Change],
) -> Change | None:
    """From when on it is another robot, for the first time after `begin`.

    All alarms are tried in turn. Where none is at the change, it lies between the
    longest part that is known to be of one robot and the shortest that is not: there
    times are tried by bisection.

    Args:
        between: what fits the part between two times, s.
        apart: how far two parts are from being of one robot.
        t: of all samples, s.
        begin: of the part, s.
        suspected: by a filter, in their order.
    """
    doubt = EARLIER * float(np.median(np.diff(t)))
    low, high, known = begin, float(t[-1]), None
    alarms = [each for each in suspected if each.t > begin]
    while alarms or (low > begin and high - low > doubt / 2):
        middle = (low + high) / 2
        tried = alarms.pop(0) if alarms else Change(middle, middle - doubt, 0.0, 0.0)
        end = alarms[0].t - doubt if alarms else np.inf
        if not low < tried.t < high:
            continue
        before = _alike(between(begin, tried.t - doubt), known)
        if before:
            low, known = tried.t, before
            # A later alarm may be none: the whole rest tells most where it fits.
            after = between(low, np.inf)
            # The part up to the next alarm may end with samples of another robot. Where
            # one robot fits up to the middle of it, none changed at this alarm.
            if not after and not between(begin, (low + end) / 2):
                after = _alike(between(low, end), before)
            off = apart(before, after) if after else ChiSquare(0.0, 0)
            if off.is_no_chance(ANOTHER_ROBOT):
                over = off.value / limit(ANOTHER_ROBOT, off.dof)
                return Change(low, tried.onset, over, 1 - off.p)
        elif low > begin:
            high = tried.t
    return None


def _alike(part: Fit | None, known: Fit | None) -> Fit | None:
    """The part, or None where more acts in it than in a part known before.

    A change of the robot shortly before a part ends may look like a torque or a force.
    """
    more = part and known and part.shown.acting - known.shown.acting
    return None if more else part


def _between(problem: MomentumProblem, begin: float, end: float) -> Fit | None:
    """What fits the part between two times, s; None where nothing does soon."""
    t = problem.recording.t
    if np.count_nonzero((t >= begin) & (t <= end)) < FEWEST:
        return None
    try:
        part = _cut(problem, begin, end)
        on, shown = evidence(part, OutputError(steps=FEW_STEPS), lambda _: None)
    except InputError:
        return None
    if shown is None or not shown.converged:
        return None
    good = all(x.level != "do not trust" for x in residual_checks(part, shown))
    return Fit(on, shown) if good else None


def _cut(problem: MomentumProblem, begin: float, end: float) -> MomentumProblem:
    """The problem of the rows between two times, s."""
    recording = problem.recording
    # What was at rest was so before the first change.
    first = begin < recording.t[0]
    known = problem if first else replace(problem, initial_momentum="unknown")
    return known.amended(recording=recording.between(begin, end))


def solve(
    robot: Robot,
    recording: Recording | LongRecording,
    initial_momentum: InitialMomentum,
    estimator: Estimator,
    progress: Progress,
) -> Solved:
    """Estimate the parameters, and fit the sensors beside it.

    Raises:
        InputError: as `identify` says.
    """

    def later(done: float) -> None:
        progress((1 + done) / 2)

    def reading(done: float) -> None:
        progress(done / 2)

    problem, shown = _begun(robot, recording, initial_momentum, estimator, reading)
    _check_outside(problem, estimator)
    problem = _with_what_is_left_out(problem, estimator)
    by_torque = _by_torque(problem, estimator)
    # What needs no fit of all comes first.
    hindered = [
        *_plainly("plain_mistake", problem, shown),
        *obstacles(problem, by_torque),
    ]
    if not hindered:
        parted = _in_parts(problem, estimator, later)
        if parted is not None:
            return parted
        hindered = _plainly("plain_change", problem, shown)
    if not hindered and shown is None:
        problem, shown = evidence(problem, estimator, later)
        hindered = obstacles(problem, by_torque)
    if hindered:
        # Nothing can be estimated: what linear fits show is kept for a look.
        estimate = LeastSquares().estimate(problem, later)
        return Solved(problem, hindered, estimate, None)
    if shown is None:
        return Solved(problem, [], estimator.estimate(problem, later), None)
    return solved_by(estimator, problem, shown, later)


def _plainly(
    what: str, problem: MomentumProblem, shown: Estimate | None
) -> list[Check]:
    """What the linear equations see of a recording that was not fitted yet."""
    return [] if shown else provided(what)(problem)


def _with_what_is_left_out(
    problem: MomentumProblem, estimator: Estimator
) -> MomentumProblem:
    """A note where scales said what the estimator does not use."""
    if problem.robot.known == KnownQuantities() or isinstance(estimator, OutputError):
        return problem
    words = (
        f"known: what was weighed is left out by {estimator.name}; identify by "
        "maximum-likelihood to use it"
    )
    return replace(problem, notes=(*problem.notes, words))


def _begun(
    robot: Robot,
    recording: Recording | LongRecording,
    initial_momentum: InitialMomentum,
    estimator: Estimator,
    progress: Progress,
) -> Evidence:
    """The problem of all rows; of a long recording what its digest shows, too."""
    if not isinstance(recording, LongRecording):
        problem = momentum_problem(robot, recording, initial_momentum, progress)
        return Evidence(problem, None)
    problem, shown = digest_of(robot, recording, initial_momentum), None
    if problem is None:
        # Something must be integrated over all rows, in memory.
        held = recording.read()
        return _begun(robot, held, initial_momentum, estimator, progress)
    if not obstacles(problem, _by_torque(problem, estimator)):
        # Its clocks are settled before all rows are read.
        problem, shown = evidence(problem, estimator, lambda _: None)
    again = not isinstance(estimator, LeastSquares)
    return Evidence(whole(problem, recording, again, progress), shown)


def _by_torque(problem: MomentumProblem, estimator: Estimator) -> bool:
    """Whether torques of joints were recorded, and the method takes them."""
    takes = isinstance(estimator, OutputError)
    return takes and bool(joints_with_torques(problem.robot, problem.recording))


def solved_by(
    estimator: Estimator, problem: MomentumProblem, shown: Estimate, progress: Progress
) -> Solved:
    """Estimate by a method what the sensors have shown already.

    Args:
        estimator: the method.
        problem: of a recording.
        shown: the estimate of it by output error.
        progress: is called with the fraction of the work that is done.
    """
    if isinstance(estimator, OutputError):
        return Solved(problem, [], shown, shown)
    whole = in_whole(problem)
    if whole and (given := shown.given()) is not None:
        problem = problem.without(given)
    estimate = estimator.estimate(problem, progress)
    off = difference(estimate.parameters.base, shown.parameters.base)
    return Solved(problem, [], widened(estimate, shown, whole), shown, off)


def _in_parts(
    problem: MomentumProblem, estimator: Estimator, progress: Progress
) -> Solved | None:
    """What is estimated where a filter finds changes; None where it finds none.

    Only those count that output error confirms, and it judges what holds since the
    last of them.
    """
    if not isinstance(estimator, Recursive) or not in_whole(problem):
        return None
    found = estimator.estimate(problem, lambda _: None).history
    if found is None or not found.changes:
        return None
    changes, last = since_the_last_change(problem, found.changes, progress)
    if last.shown is None:
        return None
    estimator = replace(estimator, changes=changes)
    if not changes:
        return solved_by(estimator, last.problem, last.shown, progress)
    # The linear equations, too, are of one robot.
    problem = replace(problem, known_fits=last.problem.fits)
    estimate = estimator.estimate(problem, lambda _: None)
    off = difference(estimate.parameters.base, last.shown.parameters.base)
    wider = widened(estimate, last.shown, whole=True)
    return Solved(last.problem, [], wider, last.shown, off)


def in_whole(problem: MomentumProblem) -> bool:
    """Whether output error fits all samples, and not only the first."""
    return problem.extent is None and problem.samples.t.size <= MOST


def _check_outside(problem: MomentumProblem, estimator: Estimator) -> None:
    """What acts from outside is identified by output error, as far as that goes.

    Raises:
        InputError: it does not go far enough.
    """
    if isinstance(estimator, OutputError):
        return
    robot, samples = problem.robot, problem.samples
    acting = [*(robot.disturbances or ())]
    if samples.wrenches:
        acting.append("thrust")
    if any(robot.momentum_walk) and isinstance(estimator, LeastSquares):
        acting.append("a walk of the momentum")
    if acting and not in_whole(problem):
        raise InputError(
            f"{samples.source}: {joined(acting)} is said to act from outside, and "
            f"{estimator.name} can take that into account in recordings of at most "
            f"{MOST} samples: its result would be wrong; use --method "
            "maximum-likelihood"
        )
    if samples.wrenches and not robot.wheels and isinstance(estimator, Recursive):
        raise InputError(
            f"{robot.name} has no wheel, and recursive cannot find the scale of its "
            "parameters by thrust alone; use another method"
        )
    if samples.wrenches and not robot.joints and isinstance(estimator, LeastSquares):
        raise InputError(
            f"{robot.name} has no joint, and {estimator.name} finds the mass by joints "
            "that move (Eq. 32); use another method"
        )
