"""The estimate from a robot and a recording, and what judges it."""

from orbident import _core
from orbident.errors import InputError
from orbident.estimation.estimate import Estimate, Estimator, Progress, Solved
from orbident.estimation.evidence import MOST, difference, evidence, widened
from orbident.estimation.least_squares import LeastSquares
from orbident.estimation.linear_fits import InitialMomentum
from orbident.estimation.long_problem import digest_problems, whole
from orbident.estimation.momentum_problem import MomentumProblem, momentum_problems
from orbident.estimation.obstacles import obstacles
from orbident.estimation.output_error.estimator import OutputError
from orbident.estimation.recursive.recursive_estimator import Recursive
from orbident.files.names import joined
from orbident.recordings.long_recording import LongRecording
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot


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

    problems = _problems(
        robot, recording, initial_momentum, estimator, lambda done: progress(done / 2)
    )
    if not isinstance(estimator, OutputError):
        _check_outside(problems[0], estimator)
    clear = [problem for problem in problems if not obstacles(problem)]
    if not clear:
        problem = problems[0]
        # Nothing can be estimated: what linear fits show is kept for a look.
        estimate = LeastSquares().estimate(problem, later)
        return Solved(problem, obstacles(problem), estimate, None)
    give_back = _core.give_back_memory if clear[0].extent else lambda: None
    give_back()
    problem, shown = evidence(clear, estimator, later)
    give_back()
    if shown is None:
        return Solved(problem, [], estimator.estimate(problem, later), None)
    return solved_by(estimator, problem, shown, later)


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
    given = shown.given() if whole else None
    if given is not None:
        problem = problem.without(given)
    estimate = estimator.estimate(problem, progress)
    off = difference(estimate.found.base, shown.found.base)
    return Solved(problem, [], widened(estimate, shown, whole), shown, off)


def in_whole(problem: MomentumProblem) -> bool:
    """Whether output error fits all samples, and not only the first."""
    return problem.extent is None and problem.samples.t.size <= MOST


def _check_outside(problem: MomentumProblem, estimator: Estimator) -> None:
    """What acts from outside is identified by output error, as far as that goes.

    Raises:
        InputError: it does not go far enough.
    """
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


def _problems(
    robot: Robot,
    recording: Recording | LongRecording,
    initial_momentum: InitialMomentum,
    estimator: Estimator,
    progress: Progress,
) -> list[MomentumProblem]:
    if isinstance(recording, LongRecording):
        found = digest_problems(robot, recording, initial_momentum)
        if found is not None:
            again = not isinstance(estimator, LeastSquares)
            found = [_on_best_clocks(found, estimator)]
            # The digest's own samples are held by nobody else.
            return [whole(found.pop(), recording, again, progress)]
        recording = recording.read()
    return momentum_problems(robot, recording, initial_momentum, progress)


def _on_best_clocks(
    problems: list[MomentumProblem], estimator: Estimator
) -> MomentumProblem:
    """The one that explains the sensors best; each is to be folded for minutes."""
    clear = [problem for problem in problems if not obstacles(problem)]
    if len(clear) < 2:
        return [*clear, *problems][0]
    return evidence(clear, estimator, lambda _: None).problem
