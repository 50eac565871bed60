"""The estimate from a robot and a recording, and what judges it."""

from typing import NamedTuple

from orbident.errors import InputError
from orbident.estimation.check import Check
from orbident.estimation.estimate import Estimate, Estimator, Progress
from orbident.estimation.evidence import MOST, difference, evidence, widened
from orbident.estimation.least_squares import LeastSquares
from orbident.estimation.linear_fits import InitialMomentum
from orbident.estimation.long_problem import long_problems
from orbident.estimation.momentum_problem import MomentumProblem, momentum_problems
from orbident.estimation.obstacles import obstacles
from orbident.estimation.output_error.estimator import OutputError
from orbident.recordings.long_recording import LongRecording
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot


class Solved(NamedTuple):
    """An estimate, not yet judged."""

    problem: MomentumProblem
    hindered: list[Check]
    """What about the recording itself forbids a result."""
    estimate: Estimate
    shown: Estimate | None
    """The estimate by output error; None where nothing can be estimated, and for exact
    recordings, which need none."""
    off: float = 0.0
    """The largest difference of these two in the estimate's own deviations, which
    include it from then on."""


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
        robot, recording, initial_momentum, lambda done: progress(done / 2)
    )
    if problems[0].samples.wrenches and not isinstance(estimator, OutputError):
        raise InputError(
            f"{recording.source}: thrusters or torquers acted, and {estimator.name} "
            "knows nothing of that: its result would be wrong; use --method "
            "maximum-likelihood"
        )
    if robot.disturbances and not isinstance(estimator, OutputError):
        raise InputError(
            f"{', '.join(robot.disturbances)} is said to act from outside, and "
            f"{estimator.name} cannot identify it: its result would be wrong; use "
            "--method maximum-likelihood"
        )
    if any(robot.momentum_walk) and isinstance(estimator, LeastSquares):
        raise InputError(
            f"{robot.name}: momentum_walk says that momentum changes at random, and "
            "least-squares takes it to be constant: its deviations would be too small; "
            "use --method structured or maximum-likelihood"
        )
    clear = [problem for problem in problems if not obstacles(problem)]
    if not clear:
        problem = problems[0]
        # Nothing can be estimated: what linear fits show is kept for a look.
        estimate = LeastSquares().estimate(problem, later)
        return Solved(problem, obstacles(problem), estimate, None)
    problem, shown = evidence(clear, estimator, later)
    if shown is not None and isinstance(estimator, OutputError):
        return Solved(problem, [], shown, shown)
    estimate = estimator.estimate(problem, later)
    if shown is None:
        return Solved(problem, [], estimate, None)
    off = difference(estimate.found.base, shown.found.base)
    whole = problem.samples.t.size <= MOST
    return Solved(problem, [], widened(estimate, shown, whole), shown, off)


def _problems(
    robot: Robot,
    recording: Recording | LongRecording,
    initial_momentum: InitialMomentum,
    progress: Progress,
) -> list[MomentumProblem]:
    if isinstance(recording, LongRecording):
        found = long_problems(robot, recording, initial_momentum, progress)
        if found is not None:
            return found
        recording = recording.read()
    return momentum_problems(robot, recording, initial_momentum, progress)
