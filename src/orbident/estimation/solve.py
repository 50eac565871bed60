"""The estimate from a robot and a recording, beside what all its sensors show."""

from dataclasses import replace

from orbident.errors import InputError
from orbident.estimation.changes import changes_of
from orbident.estimation.checks import Check
from orbident.estimation.clock_search import MOST, Evidence, evidence
from orbident.estimation.estimate import Estimate, Estimator, Progress, Solved
from orbident.estimation.least_squares import LeastSquares
from orbident.estimation.linear_fits import InitialMomentum
from orbident.estimation.momentum_problem import (
    MomentumProblem,
    digest_of,
    momentum_problem,
    whole,
)
from orbident.estimation.obstacles import no_velocity, obstacles, surprise
from orbident.estimation.output_error.estimator import OutputError
from orbident.estimation.output_error.sensors import joints_with_torques
from orbident.estimation.recursive.history import Recursive
from orbident.estimation.widening import difference, widened
from orbident.extras import provided
from orbident.files.names import joined
from orbident.recordings.long_recording import LongRecording
from orbident.recordings.recording import Recording
from orbident.robot.description import KnownQuantities, Robot


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
    # What needs no fit of all comes first.
    hindered = _seen_at_once(problem, estimator, shown)
    if not hindered and isinstance(estimator, Recursive) and in_whole(problem):
        estimator = replace(estimator, changes=changes_of(problem))
        parted = _in_parts(problem, estimator, later)
        if parted is not None:
            return parted
    elif not hindered:
        hindered = _plainly("plain_change", problem, shown)
    if not hindered and shown is None:
        problem, shown = evidence(problem, estimator, later)
        hindered = _obstacles(problem, estimator)
    if hindered:
        # Nothing can be estimated: what linear fits show is kept for a look.
        estimate = LeastSquares().estimate(problem, later)
        return Solved(problem, hindered, estimate, None)
    return solved_by(estimator, problem, shown, later)


def _seen_at_once(
    problem: MomentumProblem, estimator: Estimator, shown: Estimate | None
) -> list[Check]:
    """Plain mistakes, and what forbids a result.

    Momentum alone looks like many mistakes where it has no scale, or another one at
    first.
    """
    hindered = _obstacles(problem, estimator)
    if not problem.samples.tracked and [*hindered, *surprise(problem)]:
        return hindered
    return [*_plainly("plain_mistake", problem, shown), *hindered]


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
    if not _obstacles(problem, estimator):
        # Its clocks are settled before all rows are read.
        problem, shown = evidence(problem, estimator, lambda _: None)
    again = not isinstance(estimator, LeastSquares)
    return Evidence(whole(problem, recording, again, progress), shown)


def _obstacles(problem: MomentumProblem, estimator: Estimator) -> list[Check]:
    """Only maximum likelihood has a scale by torques, or can go without positions.

    Without these nothing shows where the CM is, beside which a force turns the robot.
    """
    if not isinstance(estimator, OutputError):
        alone = ", or identify pi alone by maximum-likelihood"
        otherwise = "" if problem.samples.wrenches else alone
        return [*obstacles(problem), *no_velocity(problem, otherwise=otherwise)]
    driven = joints_with_torques(problem.robot, problem.recording)
    forced = any(each.force.any() for each in problem.samples.wrenches)
    return [
        *obstacles(problem, bool(driven)),
        *(no_velocity(problem) if forced else ()),
    ]


def solved_by(
    estimator: Estimator,
    problem: MomentumProblem,
    shown: Estimate | None,
    progress: Progress,
) -> Solved:
    """Estimate by a method what the sensors have shown already.

    Args:
        estimator: the method.
        problem: of a recording.
        shown: the estimate of it by output error; None where there is none.
        progress: is called with the fraction of the work that is done.
    """
    if shown is None:
        return Solved(problem, [], estimator.estimate(problem, progress), None)
    if isinstance(estimator, OutputError):
        return Solved(problem, [], shown, shown)
    whole = in_whole(problem)
    if whole and (given := shown.given()) is not None:
        problem = problem.without(given)
    estimate = estimator.estimate(problem, progress)
    off = difference(estimate.parameters.base, shown.parameters.base)
    return Solved(problem, [], widened(estimate, shown, whole), shown, off)


def _in_parts(
    problem: MomentumProblem, estimator: Recursive, progress: Progress
) -> Solved | None:
    """The recursive estimate of a robot that changed, or None if it did not change.

    A filter that begins at CAD values now and then takes its own errors for a change,
    so it does not look for one itself. The robot since the last change is what it
    estimates, and output error judges that by the samples since then.
    """
    if not estimator.changes:
        return None
    # What was at rest was so before the first change.
    since = problem.recording.between(start=estimator.changes[-1].t)
    last = replace(problem, initial_momentum="unknown").amended(recording=since)
    on, shown = evidence(last, OutputError(), progress)
    if shown is None:
        return None
    # The linear equations, too, are of one robot.
    problem = replace(problem, known_fits=on.fits)
    estimate = estimator.estimate(problem, lambda _: None)
    off = difference(estimate.parameters.base, shown.parameters.base)
    return Solved(on, [], widened(estimate, shown, whole=True), shown, off)


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
